#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "bus/event_log_format.h"
#include "bus/log_window.h"

namespace vantage {

/// Tells where in a file an event is, though the file may be damaged and messages may hold whole
/// logs: by where headers lead to, and by event numbers that count up. Looks ahead of what was read
/// by so much in all as was read, and 64 MB: no file makes it slow.
class EventFinder {
 public:
  explicit EventFinder(LogWindow& window) : window_(window) {}

  struct Found {
    EventHeader header;                  ///< mended where it was damaged
    const char* mended = nullptr;        ///< what was damaged; null: nothing
    std::optional<int64_t> next_number;  ///< of the event behind it, where that is whole
  };
  /// The event whose header begins at `offset`, if all of it is there.
  /// @param last_number of the event before; nothing at the log's start.
  std::optional<Found> EventAt(int64_t offset, std::optional<int64_t> last_number);

  /// Where reading goes on after damage: the first place from `begin` on where an event of this log
  /// begins; the file's size when there is none.
  /// @param only_successors takes no event whose number does not follow `last_number`.
  int64_t FindEvent(int64_t begin, std::optional<int64_t> last_number, bool only_successors);

  /// The first place in [begin, end) with a header that two more follow, or the file's end does,
  /// and whose number is at least `min_number`; `end` when there is none.
  int64_t FindChain(int64_t begin, int64_t end, int64_t min_number);
  /// Of the headers at a place that FindChain found, the one whose utime is the median.
  std::optional<EventHeader> TypicalHeader(int64_t place);

  /// An event was read: its channel is believed where a length must be mended.
  void Learn(const EventHeader& header, std::string_view channel);

  /// The four bytes, or the few that remain at the file's end, are the sync, or one bit off.
  [[nodiscard]] bool LooksLikeSync(int64_t offset);

 private:
  enum class Link { kNone, kEnd, kHeader, kCounts };  // What is where an event should end.

  std::optional<EventHeader> HeaderAt(int64_t offset);
  std::vector<EventHeader> ChainAt(int64_t place);
  Link LinkAt(int64_t end, int64_t number);
  static bool HasRival(std::span<const std::byte> around, const EventHeader& header);
  bool IsOutrivaled(int64_t offset, const EventHeader& header);
  bool GoesOnBehind(int64_t end, int64_t counted);
  int64_t FollowCount(int64_t begin, int64_t end);
  std::optional<EventHeader> MendLengths(int64_t offset, const EventHeader& header, Link link);
  bool EndsWell(int64_t offset, const EventHeader& read, const EventHeader& mended);
  std::optional<bool> IsSoundMessage(int64_t offset, const EventHeader& header);
  int ChannelScore(int64_t offset, const EventHeader& header);
  bool HasSuccessorInside(int64_t offset, const EventHeader& header);
  int64_t FindHeader(int64_t begin, int64_t end);

  static constexpr size_t kMaxChannels = 1000;

  LogWindow& window_;
  std::set<std::string, std::less<>> channels_;
  int64_t lookahead_ = 64 << 20;  // Bytes that may yet be looked at ahead.
};

}  // namespace vantage
