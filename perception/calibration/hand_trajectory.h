#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/so3.h"

namespace vantage {

/// Where the hand was over time, as the robot tells it.
class HandTrajectory {
 public:
  struct Sample {
    int64_t utime;  ///< us
    Pose T_base_hand;
  };

  HandTrajectory() = default;
  /// In any order; of several with the same utime the last one counts.
  explicit HandTrajectory(std::vector<Sample> samples);

  /// Interpolated; nothing outside of what is known, nor across more than `largest_gap_us`.
  [[nodiscard]] std::optional<Pose> At(double utime_us, double largest_gap_us = 200'000.0) const;
  [[nodiscard]] bool empty() const { return samples_.empty(); }

 private:
  std::vector<Sample> samples_;  // By utime.
};

}  // namespace vantage
