#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bus/event_log_format.h"
#include "common/result.h"

namespace vantage {

/// One event of an LCM event log.
struct LogEvent {
  int64_t number = 0;  ///< counts events of the log, from 0
  int64_t utime = 0;   ///< us since the epoch
  std::string channel;
  std::vector<std::byte> data;
};

/// Reads an LCM event log from the front, in bounded memory, whatever is in the file. Around damage
/// it goes on with the next event that is whole, and counts.
class EventLogReader {
 public:
  struct Damage {
    int64_t num_places = 0;     ///< stretches that were skipped
    int64_t bytes_skipped = 0;  ///< in all stretches
    int64_t events_lost = 0;    ///< by gaps of the event number across stretches
    bool truncated = false;     ///< the file ends inside an event; counted in the above
    std::string read_error;     ///< why the system refused to read on; empty: it did not

    [[nodiscard]] bool any() const { return num_places > 0 || !read_error.empty(); }
    /// One sentence for people.
    [[nodiscard]] std::string Describe() const;
  };

  static constexpr int64_t kMaxEventBytes = 64 << 20;  ///< longer data is taken as damage

  /// Errors: the file is absent, unreadable, no regular file, or does not start as an LCM log.
  static Result<std::unique_ptr<EventLogReader>> Open(const std::filesystem::path& file);
  ~EventLogReader();
  EventLogReader(const EventLogReader&) = delete;
  EventLogReader& operator=(const EventLogReader&) = delete;

  /// The next event that is whole; nothing at the end.
  std::optional<LogEvent> Next();
  /// What was met so far.
  [[nodiscard]] const Damage& damage() const { return damage_; }
  [[nodiscard]] const std::filesystem::path& file() const { return file_; }
  /// Share of the file that was read, [0, 1].
  [[nodiscard]] double progress() const;

 private:
  EventLogReader(std::filesystem::path file, int descriptor, int64_t size)
      : file_(std::move(file)), descriptor_(descriptor), size_(size) {}

  bool ReadAt(int64_t offset, std::span<std::byte> bytes);
  std::optional<EventHeader> HeaderAt(int64_t offset);
  bool IsWhole(int64_t offset, const EventHeader& header);
  int64_t FindHeader(int64_t begin, int64_t end);
  void Skip(int64_t end);
  void CountLost(int64_t number);

  std::filesystem::path file_;
  int descriptor_;
  int64_t size_;         // Bytes in the file when it was opened.
  int64_t offset_ = 0;   // Of the next header.
  int64_t skipped_ = 0;  // Bytes since the last event.
  std::optional<int64_t> last_number_;
  Damage damage_;
};

/// Writes an LCM event log under a temporary name beside the wanted one, which it takes only when
/// it is complete.
class EventLogWriter {
 public:
  /// Errors: the folder is absent or can't be written.
  static Result<std::unique_ptr<EventLogWriter>> Create(const std::filesystem::path& file);
  /// Without Close() nothing is left behind.
  ~EventLogWriter();
  EventLogWriter(const EventLogWriter&) = delete;
  EventLogWriter& operator=(const EventLogWriter&) = delete;

  /// Errors: the channel is empty or longer than LCM allows, or the system refuses.
  Result<void> Write(int64_t utime, const std::string& channel, std::span<const std::byte> data);
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
