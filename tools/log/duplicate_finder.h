#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <unordered_map>
#include <vector>

#include "bus/event_log_reader.h"

namespace vantage {

/// Finds events that two recordings have of the same message: same channel and data, at most
/// kWindow apart, in different recordings. Each event stands for one of each other recording, so a
/// message that was sent twice stays twice.
class DuplicateFinder {
 public:
  static constexpr int64_t kWindow = 100'000;  ///< us

  /// Events come in the order of their times. @param source which recording it is of.
  bool IsDuplicate(const LogEventView& event, size_t source);

 private:
  struct Kept {
    int64_t utime = 0;
    std::vector<size_t> sources;  // That have it.
  };
  struct Expiry {
    int64_t utime = 0;
    uint64_t hash = 0;
  };
  void Forget(int64_t now_utime);

  std::unordered_map<uint64_t, std::deque<Kept>> kept_;  // By hash of channel and data.
  std::deque<Expiry> expiries_;                          // Of every one kept, in order.
};

}  // namespace vantage
