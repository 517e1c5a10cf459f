#include "tools/monitor/arrival_statistics.h"

#include <algorithm>
#include <cmath>

namespace vantage {

void ArrivalStatistics::Add(int64_t utime, size_t bytes) {
  if (!arrivals_.empty() && utime < arrivals_.back().utime) arrivals_.clear();
  arrivals_.push_back({utime, bytes});
  while (arrivals_.size() > kMost || utime - arrivals_.front().utime > kWindow) {
    arrivals_.pop_front();
  }
}

double ArrivalStatistics::Rate(int64_t now) const {
  const auto first = std::ranges::find_if(
      arrivals_, [now](const Arrival& each) { return now - each.utime <= kWindow; });
  const auto intervals = static_cast<double>(arrivals_.end() - first) - 1.0;
  if (intervals < 1.0) return 0.0;
  const auto span = static_cast<double>(arrivals_.back().utime - first->utime);
  const auto silence = static_cast<double>(now - arrivals_.back().utime);
  // Several at one time: a burst, whose rate is that of the window.
  if (span < 1e3) return 1e6 * (intervals + 1.0) / static_cast<double>(kWindow);
  return 1e6 * intervals / (silence > 2.0 * span / intervals ? span + silence : span);
}

double ArrivalStatistics::Bandwidth(int64_t now) const {
  if (arrivals_.empty()) return 0.0;
  double bytes = 0.0;
  for (const Arrival& each : arrivals_) bytes += static_cast<double>(each.bytes);
  return Rate(now) * bytes / static_cast<double>(arrivals_.size());
}

double ArrivalStatistics::Jitter() const {
  if (arrivals_.size() < 3) return 0.0;
  const auto intervals = static_cast<double>(arrivals_.size() - 1);
  const double mean =
      static_cast<double>(arrivals_.back().utime - arrivals_.front().utime) / intervals;
  double squares = 0.0;
  for (size_t i = 1; i < arrivals_.size(); ++i) {
    const double off = static_cast<double>(arrivals_[i].utime - arrivals_[i - 1].utime) - mean;
    squares += off * off;
  }
  return 1e-6 * std::sqrt(squares / (intervals - 1.0));
}

}  // namespace vantage
