#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>

namespace vantage {

/// How a channel's messages arrived of late: within the last five seconds, and of these the last
/// 512. Times are us since the epoch; one that goes back begins anew.
class ArrivalStatistics {
 public:
  void Add(int64_t utime, size_t bytes);

  /// Hz. It falls once the channel has been silent for longer than two intervals. 0 for fewer than
  /// two messages.
  [[nodiscard]] double Rate(int64_t now) const;
  /// Bytes per second.
  [[nodiscard]] double Bandwidth(int64_t now) const;
  /// s, standard deviation of the time from one message to the next; 0 for fewer than three.
  [[nodiscard]] double Jitter() const;

  static constexpr int64_t kWindow = 5'000'000;  ///< us
  static constexpr size_t kMost = 512;           ///< messages

 private:
  struct Arrival {
    int64_t utime = 0;
    size_t bytes = 0;
  };
  std::deque<Arrival> arrivals_;
};

}  // namespace vantage
