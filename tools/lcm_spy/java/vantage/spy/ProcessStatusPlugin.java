package vantage.spy;

import lcm.spy.SpyPlugin;
import vantage.process_status_t;

/** How all processes fare. */
public final class ProcessStatusPlugin extends MessagePlugin implements SpyPlugin {
  public ProcessStatusPlugin() {
    super("Processes", process_status_t.LCM_FINGERPRINT, ProcessView::new);
  }
}
