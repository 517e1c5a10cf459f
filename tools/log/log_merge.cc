#include "tools/log/log_merge.h"

#include <algorithm>
#include <utility>

#include "bus/message_check.h"
#include "common/format.h"
#include "tools/log/duplicate_finder.h"
#include "tools/log/event_type.h"
#include "tools/log/shown_text.h"
#include "vantage/log_header_t.hpp"

namespace vantage {
namespace {

constexpr size_t kMaxConflicts = 20;

// In what two headers differ, in words; empty: in nothing that matters.
std::string Differences(std::span<const std::byte> kept, std::span<const std::byte> other) {
  if (std::ranges::equal(kept, other)) return "";
  const Result<log_header_t> a = DecodeChecked<log_header_t>(kept);
  const Result<log_header_t> b = DecodeChecked<log_header_t>(other);
  if (!a || !b) return "one of them can't be read here";
  std::string text;
  const auto add = [&text](const std::string& what) { text += (text.empty() ? "" : ", ") + what; };
  if (a->version != b->version) {
    add(Format("version %s and %s", Printable(a->version).c_str(), Printable(b->version).c_str()));
  }
  if (a->seed != b->seed) add(Format("seed %jd and %jd", intmax_t{a->seed}, intmax_t{b->seed}));
  if (a->config_text != b->config_text) add("the configuration");
  if (a->schema_fingerprints != b->schema_fingerprints) add("the message types");
  return text;
}

}  // namespace

LogMerge::LogMerge(std::vector<std::unique_ptr<EventLogReader>> logs)
    : logs_(std::move(logs)), heads_(logs_.size()) {}

Result<std::optional<LogMergeSummary>> LogMerge::Run(bool drop_duplicates,
                                                     const GoOn& go_on,
                                                     EventLogWriter& writer) {
  for (size_t i = 0; i < logs_.size(); ++i) Advance(i);
  DuplicateFinder duplicates;
  int64_t done_bytes = 0;
  if (Result<void> written = WriteHeader(writer); !written) return written.error();
  for (std::optional<size_t> log = Earliest(); log; log = Earliest()) {
    const LogEventView& event = *heads_[*log];
    done_bytes += static_cast<int64_t>(event.data.size());
    if (!go_on(done_bytes)) return std::optional<LogMergeSummary>();
    if (header_ && event.channel == kLogHeaderChannel) {
      CompareHeader(*logs_[*log], event);
    } else if (drop_duplicates && duplicates.IsDuplicate(event, *log)) {
      ++summary_.num_duplicates;
    } else if (Result<void> written = writer.Write(event.utime, event.channel, event.data);
               !written) {
      return written.error();
    }
    Advance(*log);
  }
  return std::optional(summary_);
}

void LogMerge::Advance(size_t log) { heads_[log] = logs_[log]->NextView(); }

std::optional<size_t> LogMerge::Earliest() const {
  std::optional<size_t> earliest;
  for (size_t i = 0; i < heads_.size(); ++i) {
    if (heads_[i] && (!earliest || heads_[i]->utime < heads_[*earliest]->utime)) earliest = i;
  }
  return earliest;
}

// At the time of the first event of all: a player would wait all the time between.
Result<void> LogMerge::WriteHeader(EventLogWriter& writer) {
  const std::optional<size_t> earliest = Earliest();
  for (const std::optional<LogEventView>& head : heads_) {
    if (!head || head->channel != kLogHeaderChannel) continue;
    header_ = LogEvent{.utime = heads_[*earliest]->utime,
                       .channel = kLogHeaderChannel,
                       .data = {head->data.begin(), head->data.end()}};
    return writer.Write(header_->utime, header_->channel, header_->data);
  }
  return {};
}

void LogMerge::CompareHeader(const EventLogReader& log, const LogEventView& header) {
  const std::string differences = Differences(header_->data, header.data);
  if (differences.empty() || summary_.conflicts.size() >= kMaxConflicts) return;
  summary_.conflicts.push_back(
      Format("LOG_HEADER of %s differs from the one kept: ", log.file().c_str()) + differences);
}

}  // namespace vantage
