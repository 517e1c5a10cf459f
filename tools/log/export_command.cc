#include "tools/log/export_command.h"

#include <cstdint>
#include <cstdio>
#include <limits>
#include <optional>

#include "common/format.h"
#include "tools/log/channel_choice.h"
#include "tools/log/log_output.h"
#include "tools/log/log_progress.h"
#include "tools/support/interrupt.h"
#include "tools/support/log_place.h"

namespace vantage {

ExportCommand::ExportCommand(CLI::App* app)
    : command_(app->add_subcommand("export", "write images, tables, clouds or MCAP of a log")) {
  command_->add_option("log", log_, "the log")->required();
  command_->add_option("--output,-o", output_, "folder to make; for mcap the file")->required();
  command_->add_option("--format", format_, "images, csv, ply or mcap")
      ->required()
      ->check(CLI::IsMember({"images", "csv", "ply", "mcap"}));
  command_->add_option("--channels", channels_, "regular expressions of the channels (all)");
  command_->add_option("--exclude", exclude_, "the same, of channels to leave out");
  command_->add_option("--from", from_, "seconds from the log's start, or a utime in us (start)");
  command_->add_option("--to", to_, "the same; events at this time are left out (end)");
  command_->add_flag("--merge", merge_, "ply: one cloud for each camera");
}

Result<std::unique_ptr<LogExporter>> ExportCommand::MakeExporter() const {
  if (merge_ && format_ != "ply") {
    return Error{ErrorCode::kInvalidArgument,
                 Format("--merge with --format %s, expected it with ply", format_.c_str())};
  }
  if (format_ == "images") return MakeImageExporter(output_);
  if (format_ == "csv") return MakeCsvExporter(output_);
  if (format_ == "ply") return MakePlyExporter(output_, merge_);
  return MakeMcapExporter(output_);
}

Result<int> ExportCommand::Run() const {
  Result<std::unique_ptr<EventLogReader>> reader = EventLogReader::Open(log_);
  if (!reader) return reader.error();
  Result<ChannelChoice> choice = ChannelChoice::Create(channels_, exclude_);
  if (!choice) return choice.error();
  std::optional<LogEventView> event = (*reader)->NextView();
  if (!event) return Error{ErrorCode::kCorrupt, Format("log %s has no whole event", log_.c_str())};
  int64_t from = std::numeric_limits<int64_t>::min();
  int64_t to = std::numeric_limits<int64_t>::max();
  for (const auto& [option, text, place] :
       {std::tuple{"--from", &from_, &from}, std::tuple{"--to", &to_, &to}}) {
    if (text->empty()) continue;
    const Result<int64_t> parsed = ParseLogPlace(option, *text, event->utime);
    if (!parsed) return parsed.error();
    *place = *parsed;
  }
  if (from >= to) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("--from %s is not before --to %s, expected a stretch of time",
                        from_.c_str(),
                        to_.c_str())};
  }
  const Interrupt interrupt("the event in work");
  Result<std::unique_ptr<LogExporter>> exporter = MakeExporter();
  if (!exporter) return exporter.error();
  LogProgress progress((*reader)->file_bytes());
  for (; event; event = (*reader)->NextView()) {
    if (interrupt.token().stop_requested()) return kInterrupted;
    const bool chosen = choice->Wants(event->channel);
    const bool wanted = chosen && event->utime >= from && event->utime < to;
    if (Result<void> added = (*exporter)->Add(*event, wanted); !added) return added.error();
    progress.Show((*reader)->offset());
  }
  if (Result<void> met = choice->Validate(log_); !met) return met.error();
  const Result<std::string> finished = (*exporter)->Finish();
  if (!finished) {
    return Error{finished.error().code,
                 Format("log %s: %s", log_.c_str(), finished.error().message.c_str())};
  }
  TellDamage(**reader);
  std::printf("%swrote %s\n", finished->c_str(), output_.c_str());
  return 0;
}

}  // namespace vantage
