#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "bus/event_log_reader.h"
#include "tools/log/odd_value.h"

namespace vantage {

/// Looks for events that were read but can't be as they were recorded: a bit that flipped in the
/// event number, utime, channel or data breaks no event's frame. In bounded memory.
///
/// Numbers, times and counts are doubted where one leaves a row that goes on without it; data where
/// they are not what their type is, or what nodes refuse; channels and types, when all was seen,
/// where they are nearly those of many others.
class LogCheck {
 public:
  struct Doubt {
    EventPlace place;
    std::string reason;
  };
  static constexpr size_t kMaxDoubts = 1000;    ///< listed; num_doubts() counts all
  static constexpr size_t kMaxChannels = 5000;  ///< looked at for odd names, types and counts

  void Add(const LogEventView& event);
  /// All was added: judges what needs the whole log.
  void Finish();

  /// After Finish(), in the order of the file.
  [[nodiscard]] const std::vector<Doubt>& doubts() const { return doubts_; }
  [[nodiscard]] int64_t num_doubts() const { return num_doubts_; }
  [[nodiscard]] int64_t num_events() const { return num_events_; }
  /// Times that event numbers went on elsewhere: somebody took events out, or put logs together.
  [[nodiscard]] int64_t num_jumps() const { return numbers_.num_jumps(); }

 private:
  struct Seen {
    int64_t count = 0;
    EventPlace first;
  };
  struct Channel {
    int64_t count = 0;
    std::map<int64_t, Seen> types;  // By fingerprint.
  };

  void DoubtTime(const std::optional<OddValue>& odd);
  void DoubtNumber(const std::optional<OddValue>& odd);
  void CheckData(const EventPlace& place, std::span<const std::byte> data);
  void CountTypes(const EventPlace& place, std::span<const std::byte> data);
  void JudgeChannel(const std::string& name, const Channel& channel);
  void AddDoubt(const EventPlace& place, std::string reason);

  int64_t num_events_ = 0;
  int64_t num_doubts_ = 0;
  CountRow numbers_;
  TimeRow times_;
  std::map<std::string, CountRow, std::less<>> counts_;  // Of seq, by sender.
  std::map<std::string, Channel, std::less<>> channels_;
  std::vector<Doubt> doubts_;
};

}  // namespace vantage
