#include "tools/log/filter_command.h"

#include <memory>
#include <optional>

#include "tools/log/channel_choice.h"
#include "tools/log/log_progress.h"
#include "tools/support/interrupt.h"

namespace vantage {

FilterCommand::FilterCommand(CLI::App* app)
    : command_(app->add_subcommand("filter", "write a log of some of the channels")),
      output_(command_) {
  command_->add_option("log", log_, "the log")->required();
  command_
      ->add_option("--channels",
                   channels_,
                   "regular expression of whole names to keep, may be given several times (all)")
      ->allow_extra_args(false);
  command_->add_option("--exclude", exclude_, "the same, of channels to leave out")
      ->allow_extra_args(false);
}

Result<int> FilterCommand::Run() const {
  if (channels_.empty() && exclude_.empty()) {
    return Error{ErrorCode::kInvalidArgument,
                 "filter with neither --channels nor --exclude, expected one of them"};
  }
  Result<ChannelChoice> choice = ChannelChoice::Create(channels_, exclude_);
  if (!choice) return choice.error();
  Result<std::unique_ptr<EventLogReader>> reader = EventLogReader::Open(log_);
  if (!reader) return reader.error();
  Result<std::unique_ptr<EventLogWriter>> writer = output_.Create({log_});
  if (!writer) return writer.error();
  const Interrupt interrupt("this event; the log is not written");
  {
    LogProgress progress((*reader)->file_bytes());
    while (const std::optional<LogEventView> event = (*reader)->NextView()) {
      if (interrupt.token().stop_requested()) return kInterrupted;
      progress.Show((*reader)->offset());
      if (!choice->Wants(event->channel)) continue;
      if (Result<void> written = (*writer)->Write(event->utime, event->channel, event->data);
          !written) {
        return written.error();
      }
    }
  }
  if (Result<void> there = choice->Validate(log_); !there) return there.error();
  if (Result<void> closed = output_.Close(**writer); !closed) return closed.error();
  TellDamage(**reader);
  return 0;
}

}  // namespace vantage
