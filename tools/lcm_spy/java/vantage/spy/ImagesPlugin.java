package vantage.spy;

import lcm.spy.SpyPlugin;
import vantage.images_t;

/** The images of a camera. */
public final class ImagesPlugin extends MessagePlugin implements SpyPlugin {
  public ImagesPlugin() {
    super("Images", images_t.LCM_FINGERPRINT, PicturesView::new);
  }
}
