package vantage.spy;

import lcm.spy.SpyPlugin;
import vantage.detections_v2_t;

/** What an estimator found in the last image. */
public final class DetectionsPlugin extends MessagePlugin implements SpyPlugin {
  public DetectionsPlugin() {
    super(
        "Detections",
        detections_v2_t.LCM_FINGERPRINT,
        worker -> new ListView<>(
            detections_v2_t.class,
            message -> message.seq,
            DetectionRows::of,
            new TablesPanel(1000, 220)));
  }
}
