package vantage.spy;

import java.util.Map;
import java.util.TreeMap;
import java.util.concurrent.Executor;
import javax.swing.JComponent;
import vantage.process_status_t;

/** The last PROCESS_STATUS of each process. */
final class ProcessView implements MessageView {
  private static final int MAX_PROCESSES = 100;

  private final TablesPanel tables = new TablesPanel(900, 150, 190, 190);
  private final Map<String, process_status_t> latest = new TreeMap<>(); // Swing thread's.

  ProcessView(Executor worker) {}

  @Override
  public JComponent component() {
    return tables.component();
  }

  @Override
  public int queueLength() {
    return MAX_PROCESSES;
  }

  @Override
  public Runnable prepare(Object message) {
    process_status_t status = (process_status_t) message;
    return () -> {
      String name = status.name + "@" + status.host;
      if (latest.containsKey(name) || latest.size() < MAX_PROCESSES) {
        latest.put(name, status);
      }
      refresh(1000 * System.currentTimeMillis());
    };
  }

  @Override
  public void refresh(long nowUtime) {
    tables.show(ProcessRows.of(latest.values(), nowUtime));
  }
}
