package vantage.spy;

import lcm.spy.SpyPlugin;
import vantage.next_view_t;

/** The views that the planner considered. */
public final class NextViewPlugin extends MessagePlugin implements SpyPlugin {
  public NextViewPlugin() {
    super(
        "Next view",
        next_view_t.LCM_FINGERPRINT,
        // A decision that is repeated has the same seq, so losses cannot be seen by it.
        worker -> new ListView<>(
            next_view_t.class, message -> -1, CandidateRows::of, new TablesPanel(900, 320)));
  }
}
