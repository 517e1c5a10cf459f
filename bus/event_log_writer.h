#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <span>
#include <string_view>
#include <utility>

#include "common/result.h"

namespace vantage {

/// Writes an LCM event log under a temporary name beside the wanted one, which it takes only when
/// it is complete. Events are numbered from 0.
class EventLogWriter {
 public:
  /// Errors: the folder is absent or can't be written.
  static Result<std::unique_ptr<EventLogWriter>> Create(const std::filesystem::path& file);
  /// Without Close() nothing is left behind.
  ~EventLogWriter();
  EventLogWriter(const EventLogWriter&) = delete;
  EventLogWriter& operator=(const EventLogWriter&) = delete;

  /// Errors: the channel is empty or longer than LCM allows, the data longer than logs take, or the
  /// system refuses.
  Result<void> Write(int64_t utime, std::string_view channel, std::span<const std::byte> data);
  /// Moves the log to its name. Nothing may be written after. Errors: the system refuses.
  Result<void> Close();
  [[nodiscard]] int64_t num_events() const { return num_events_; }

 private:
  EventLogWriter(std::filesystem::path file, std::filesystem::path temporary, std::FILE* stream)
      : file_(std::move(file)), temporary_(std::move(temporary)), stream_(stream) {}

  std::filesystem::path file_;
  std::filesystem::path temporary_;
  std::FILE* stream_;
  int64_t num_events_ = 0;
};

}  // namespace vantage
