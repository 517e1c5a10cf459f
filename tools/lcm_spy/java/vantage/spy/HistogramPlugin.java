package vantage.spy;

import lcm.spy.SpyPlugin;
import vantage.orientation_histogram_t;

/** The orientation histograms of all objects on spheres. */
public final class HistogramPlugin extends MessagePlugin implements SpyPlugin {
  public HistogramPlugin() {
    super("Orientation histogram", orientation_histogram_t.LCM_FINGERPRINT, HistogramView::new);
  }
}
