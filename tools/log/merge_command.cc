#include "tools/log/merge_command.h"

#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <system_error>

#include "common/format.h"
#include "tools/log/log_merge.h"
#include "tools/log/log_progress.h"
#include "tools/support/interrupt.h"

namespace vantage {
namespace {

Result<std::vector<std::unique_ptr<EventLogReader>>> OpenAll(
    const std::vector<std::string>& files) {
  std::vector<std::unique_ptr<EventLogReader>> readers;
  for (size_t i = 0; i < files.size(); ++i) {
    Result<std::unique_ptr<EventLogReader>> reader = EventLogReader::Open(files[i]);
    if (!reader) return reader.error();
    for (size_t k = 0; k < i; ++k) {
      std::error_code error;
      if (!std::filesystem::equivalent(files[i], files[k], error)) continue;
      return Error{ErrorCode::kInvalidArgument,
                   Format("%s is named twice, expected different logs", files[i].c_str())};
    }
    readers.push_back(std::move(reader).value());
  }
  return readers;
}

}  // namespace

MergeCommand::MergeCommand(CLI::App* app)
    : command_(app->add_subcommand("merge", "write one log of several, by time")),
      output_(command_) {
  command_->add_option("logs", logs_, "two logs or more")->required()->expected(2, 100);
  command_->add_flag("--drop-duplicates",
                     drop_duplicates_,
                     "of messages that several logs have, keep one: same channel and data, at most "
                     "0.1 s apart");
}

Result<int> MergeCommand::Run() const {
  Result<std::vector<std::unique_ptr<EventLogReader>>> readers = OpenAll(logs_);
  if (!readers) return readers.error();
  int64_t total_bytes = 0;
  for (const auto& reader : *readers) total_bytes += reader->file_bytes();
  Result<std::unique_ptr<EventLogWriter>> writer = output_.Create(logs_);
  if (!writer) return writer.error();
  const Interrupt interrupt("this event; the log is not written");
  LogMerge merge(std::move(readers).value());
  std::optional<LogMergeSummary> summary;
  {
    LogProgress progress(total_bytes);
    Result<std::optional<LogMergeSummary>> merged = merge.Run(
        drop_duplicates_,
        [&](int64_t done_bytes) {
          progress.Show(done_bytes);
          return !interrupt.token().stop_requested();
        },
        **writer);
    if (!merged) return merged.error();
    summary = *merged;
  }
  if (!summary) return kInterrupted;
  if (Result<void> closed = output_.Close(**writer); !closed) return closed.error();
  if (drop_duplicates_) std::printf("%jd duplicates dropped\n", intmax_t{summary->num_duplicates});
  for (const std::string& conflict : summary->conflicts) {
    std::fprintf(stderr, "vantage-log: %s\n", conflict.c_str());
  }
  for (const auto& reader : merge.logs()) TellDamage(*reader);
  return 0;
}

}  // namespace vantage
