#pragma once

#include <cstdint>

namespace vantage {

/// Chooses among measurements so that about `rate_hz` a second are left, evenly, by their times
/// alone: at 30 Hz and a limit of 10 Hz exactly every third.
class RateLimiter {
 public:
  /// @param rate_hz Hz; 0 or less: all pass.
  explicit RateLimiter(double rate_hz) { SetRate(rate_hz); }
  void SetRate(double rate_hz);

  /// Whether the measurement of this time passes. Times may step; it then starts anew.
  bool Accept(int64_t utime);

 private:
  int64_t period_us_ = 0;  // 0: all pass
  int64_t due_ = 0;
  bool started_ = false;
};

}  // namespace vantage
