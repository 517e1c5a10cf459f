package vantage.spy;

import java.util.Collection;
import java.util.List;
import vantage.channel_status_t;
import vantage.process_status_t;
import vantage.stage_status_t;

/** PROCESS_STATUS of several processes as tables: processes, their channels, their stages. */
final class ProcessRows {
  private static final double SILENT_S = 3; // Three statuses are missing.

  private ProcessRows() {}

  static List<Rows> of(Collection<process_status_t> processes, long nowUtime) {
    Rows states = new Rows(
        "Processes: " + processes.size(),
        "process", "host", "pid", "state", "version", "config", "up", "buffer, kB", "age");
    Rows channels = new Rows(
        "What they listen to",
        "process", "channel", "rate, Hz", "age", "received", "lost", "overwritten", "refused");
    Rows stages = new Rows(
        "How long their stages take",
        "process", "stage", "runs", "p50, ms", "p99, ms", "max, ms");
    for (process_status_t process : processes) {
      addProcess(process, nowUtime, states);
      for (channel_status_t channel : process.channels) {
        channels.add(
            channel.num_lost > 0 || channel.num_decode_errors > 0,
            Text.line(process.name),
            Text.line(channel.channel),
            Text.number(channel.rate, 1),
            channel.age < 0 ? "never" : Text.duration(channel.age),
            Long.toString(channel.num_received),
            Long.toString(channel.num_lost),
            Long.toString(channel.num_overwritten),
            Long.toString(channel.num_decode_errors));
      }
      for (stage_status_t stage : process.stages) {
        stages.add(
            false,
            Text.line(process.name),
            Text.line(stage.stage),
            Long.toString(stage.num_runs),
            Text.number(1000 * stage.latency_p50, 2),
            Text.number(1000 * stage.latency_p99, 2),
            Text.number(1000 * stage.latency_max, 2));
      }
    }
    return List.of(states, channels, stages);
  }

  private static void addProcess(process_status_t process, long nowUtime, Rows rows) {
    boolean silent = 1e-6 * ((double) nowUtime - process.utime) > SILENT_S;
    boolean small = process.receive_buffer_granted < process.receive_buffer_requested;
    rows.add(
        silent || small || !"ok".equals(process.state),
        Text.line(process.name),
        Text.line(process.host),
        Integer.toString(process.pid),
        Text.line(process.state),
        Text.line(process.version),
        Text.line(process.config_hash),
        Text.age(process.start_utime, process.utime),
        Text.number(process.receive_buffer_granted / 1024.0, 0) + " of "
            + Text.number(process.receive_buffer_requested / 1024.0, 0),
        Text.age(process.utime, nowUtime));
  }
}
