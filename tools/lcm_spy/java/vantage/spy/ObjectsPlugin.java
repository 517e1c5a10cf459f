package vantage.spy;

import lcm.spy.SpyPlugin;
import vantage.object_estimates_v3_t;

/** The objects with how well they are known. */
public final class ObjectsPlugin extends MessagePlugin implements SpyPlugin {
  public ObjectsPlugin() {
    super(
        "Objects",
        object_estimates_v3_t.LCM_FINGERPRINT,
        worker -> new ListView<>(
            object_estimates_v3_t.class,
            message -> message.seq,
            ObjectRows::of,
            new TablesPanel(1100, 160, 160)));
  }
}
