#include "drivers/clock/rate_limiter.h"

#include <cmath>

namespace vantage {

void RateLimiter::SetRate(double rate_hz) {
  period_us_ = rate_hz > 0.0 ? static_cast<int64_t>(std::llround(1e6 / rate_hz)) : 0;
  started_ = false;
}

bool RateLimiter::Accept(int64_t utime) {
  if (period_us_ <= 0) return true;
  const bool stepped_back = utime < due_ - 2 * period_us_;
  if (started_ && !stepped_back) {
    // A quarter of a period early is near enough: stamps jitter, and waiting for the next frame
    // would miss by more.
    if (utime < due_ - period_us_ / 4) return false;
    due_ += period_us_;
    if (due_ > utime) return true;
  }
  started_ = true;
  due_ = utime + period_us_;
  return true;
}

}  // namespace vantage
