#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "bus/event_finder.h"
#include "bus/log_damage.h"
#include "bus/log_window.h"
#include "common/result.h"

namespace vantage {

/// One event of an LCM event log.
struct LogEvent {
  int64_t number = 0;  ///< counts events of the log, from 0; as it is in the file
  int64_t utime = 0;   ///< us since the epoch
  std::string channel;
  std::vector<std::byte> data;
};

/// The same without a copy: in the reader's memory, until the reader is used again.
struct LogEventView {
  int64_t number = 0;
  int64_t utime = 0;
  std::string_view channel;
  std::span<const std::byte> data;
  int64_t offset = 0;  ///< bytes from the start of the file to the event's header
};

/// Reads an LCM event log in blocks, in bounded memory, whatever is in the file.
///
/// An event's header has no checksum. It is believed when the next one follows where it says. One
/// that is damaged in its sync or lengths is mended where the headers around say how; else reading
/// goes on with the next event that is whole, and what was skipped is counted and listed. Damage of
/// number, utime, channel and data can't be seen here: `vantage-log check` looks for it.
class EventLogReader {
 public:
  using Damage = LogDamage;
  static constexpr int64_t kMaxEventBytes = EventHeader::kMaxDataBytes;

  /// Errors: the file is absent, unreadable, no regular file, or no events begin in its first MiB.
  static Result<std::unique_ptr<EventLogReader>> Open(const std::filesystem::path& file);
  ~EventLogReader();
  EventLogReader(const EventLogReader&) = delete;
  EventLogReader& operator=(const EventLogReader&) = delete;

  /// The next event that is whole; nothing at the end.
  std::optional<LogEvent> Next();
  /// The same without a copy; valid until the reader is used again.
  std::optional<LogEventView> NextView();

  /// The next event that is read will be the first one at or after `utime`, us since the epoch; the
  /// log's first for INT64_MIN. Looks at some dozens of places of the file, so it needs no index
  /// and takes milliseconds on a log of any size, forward and back. It counts on times that go up:
  /// where some go back, events at or after `utime` may lie before the place that is found, and
  /// events before it behind; who needs them all seeks an earlier time and looks at each event.
  /// What is passed over does not count as damage.
  void SeekUtime(int64_t utime);

  struct TimeSpan {
    int64_t first_utime = 0;  ///< us since the epoch, of the log's first event
    int64_t last_utime = 0;   ///< of its last
  };
  /// From both ends of the file, in milliseconds; the next event is the same as before. Nothing
  /// when no event is whole.
  std::optional<TimeSpan> FindTimeSpan();

  /// What was met so far.
  [[nodiscard]] const Damage& damage() const { return damage_; }
  [[nodiscard]] const std::filesystem::path& file() const { return file_; }
  /// Share of the file that was read, [0, 1].
  [[nodiscard]] double progress() const {
    return static_cast<double>(offset_) / static_cast<double>(window_.size());
  }
  [[nodiscard]] int64_t offset() const { return offset_; }  ///< bytes, to where it goes on
  [[nodiscard]] int64_t file_bytes() const { return window_.size(); }  ///< when it was opened

 private:
  EventLogReader(std::filesystem::path file, int descriptor, int64_t size);

  void MoveTo(int64_t offset, std::optional<int64_t> last_number);
  void Skip();
  void Mended(const EventHeader& header, const char* what);
  void EndSkip(std::optional<int64_t> number);
  void AddPlace(const Damage::Place& place);

  std::filesystem::path file_;
  LogWindow window_;
  EventFinder finder_;
  int64_t offset_ = 0;                    // Of the next header.
  std::optional<int64_t> last_number_;    // Of the event before.
  std::optional<Damage::Place> skipped_;  // Since the last event.
  Damage damage_;
};

}  // namespace vantage
