#pragma once

#include <cstdint>
#include <functional>
#include <stop_token>

#include "tools/evaluate/handeye_results.h"

namespace vantage {

struct HandEyeRequest {
  int trials = 1000;  ///< of ours in each cell; the others get a fifth of them
  uint64_t seed = 1;
};

/// Simulated calibrations from 20, 30 and 50 views with 0, 10 and 30 % outliers in either setup by
/// ours and the others, and degenerate motions by ours; all but the times follows from the seed.
/// @return false after a stop.
bool EvaluateHandEye(const HandEyeRequest& request,
                     const std::stop_token& stop,
                     const std::function<void(int64_t done, int64_t total)>& progress,
                     HandEyeResults* results);

}  // namespace vantage
