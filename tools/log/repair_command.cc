#include "tools/log/repair_command.h"

#include <cstdio>
#include <memory>
#include <optional>

#include "tools/log/log_progress.h"
#include "tools/support/interrupt.h"

namespace vantage {

RepairCommand::RepairCommand(CLI::App* app)
    : command_(app->add_subcommand("repair", "write a log of all events that are whole")),
      output_(command_) {
  command_->add_option("log", log_, "the damaged log; it stays as it is")->required();
}

Result<int> RepairCommand::Run() const {
  Result<std::unique_ptr<EventLogReader>> reader = EventLogReader::Open(log_);
  if (!reader) return reader.error();
  Result<std::unique_ptr<EventLogWriter>> writer = output_.Create({log_});
  if (!writer) return writer.error();
  const Interrupt interrupt("this event; the log is not written");
  {
    LogProgress progress((*reader)->file_bytes());
    while (const std::optional<LogEventView> event = (*reader)->NextView()) {
      if (interrupt.token().stop_requested()) return kInterrupted;
      if (Result<void> written = (*writer)->Write(event->utime, event->channel, event->data);
          !written) {
        return written.error();
      }
      progress.Show((*reader)->offset());
    }
  }
  if (Result<void> closed = output_.Close(**writer); !closed) return closed.error();
  const LogDamage& damage = (*reader)->damage();
  for (const LogDamage::Place& place : damage.places) {
    std::printf("  %s\n", place.Describe().c_str());
  }
  const int64_t all = damage.num_places + damage.events_mended;
  if (all > static_cast<int64_t>(damage.places.size())) {
    std::printf("  and %jd more places\n", intmax_t{all} - intmax_t(damage.places.size()));
  }
  std::printf("%s\n", damage.any() ? damage.Describe().c_str() : "nothing was damaged");
  return 0;
}

}  // namespace vantage
