#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace vantage {

/// An event for people.
struct EventPlace {
  int64_t offset = 0;  ///< bytes from the start of the file
  int64_t number = 0;  ///< of the event, by its place in the log
  int64_t utime = 0;   ///< us since the epoch
  std::string channel;
};

/// A value that leaves a row which goes on without it.
struct OddValue {
  EventPlace place;
  int64_t value = 0;
  int64_t expected = 0;  ///< near it, or itself
};

/// Finds odd ones in a row of numbers that count up by one. Gaps, and rows that begin anew, are
/// no odd values.
class CountRow {
 public:
  std::optional<OddValue> Add(int64_t value, const EventPlace& place);
  /// The row has ended: of the last value.
  [[nodiscard]] std::optional<OddValue> Finish() const;
  /// Times that the row went on elsewhere than expected.
  [[nodiscard]] int64_t num_jumps() const { return num_jumps_; }

 private:
  int64_t num_values_ = 0;
  int64_t num_jumps_ = 0;
  int64_t last_ = 0;  // The last one that is believed.
  EventPlace first_place_;
  std::optional<OddValue> open_;  // One that the next decides about.
};

/// Finds odd ones in a row of times, us, that go up. A clock that was set back is no odd value; a
/// pause of more than a day is, at the ends.
class TimeRow {
 public:
  std::optional<OddValue> Add(int64_t utime, const EventPlace& place);
  /// The row has ended: of the last value.
  [[nodiscard]] std::optional<OddValue> Finish() const;

 private:
  int64_t num_values_ = 0;
  std::optional<int64_t> before_;  // Believed.
  EventPlace first_place_;
  std::optional<OddValue> open_;  // The next decides about it.
};

}  // namespace vantage
