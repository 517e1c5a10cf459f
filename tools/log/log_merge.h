#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bus/event_log_reader.h"
#include "bus/event_log_writer.h"
#include "common/result.h"

namespace vantage {

struct LogMergeSummary {
  int64_t num_duplicates = 0;          ///< dropped
  std::vector<std::string> conflicts;  ///< in which LOG_HEADERs contradict the one kept
};

/// Merges logs by utime while they are read; at the same time, the log that is named first comes
/// first. A log whose own times go back keeps its order. The first log that has a LOG_HEADER gives
/// it to the output, as its first event.
class LogMerge {
 public:
  /// Told bytes read so far; false: to end early.
  using GoOn = std::function<bool(int64_t done_bytes)>;

  explicit LogMerge(std::vector<std::unique_ptr<EventLogReader>> logs);

  /// Nothing when `go_on` ended it. Errors: the writer's.
  Result<std::optional<LogMergeSummary>> Run(bool drop_duplicates,
                                             const GoOn& go_on,
                                             EventLogWriter& writer);

  [[nodiscard]] const std::vector<std::unique_ptr<EventLogReader>>& logs() const { return logs_; }

 private:
  void Advance(size_t log);
  [[nodiscard]] std::optional<size_t> Earliest() const;
  Result<void> WriteHeader(EventLogWriter& writer);
  void CompareHeader(const EventLogReader& log, const LogEventView& header);

  std::vector<std::unique_ptr<EventLogReader>> logs_;
  std::vector<std::optional<LogEventView>> heads_;  // Of each log.
  std::optional<LogEvent> header_;                  // That is kept.
  LogMergeSummary summary_;
};

}  // namespace vantage
