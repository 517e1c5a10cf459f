#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "common/so3.h"

namespace vantage {

/// Recent poses of one camera by measurement time; answers where it was, and whether it rested.
class PoseBuffer {
 public:
  struct Parameters {
    int64_t horizon_us = 10'000'000;       ///< us; older poses are forgotten
    int64_t largest_gap_us = 200'000;      ///< us; no interpolation across a longer silence
    double rest_translation = 0.0005;      ///< m; at rest if it moved less than this
    double rest_rotation = 0.1 * kDegree;  ///< rad; and turned less than this
  };

  PoseBuffer() = default;
  explicit PoseBuffer(const Parameters& parameters) : parameters_(parameters) {}

  /// Poses may come out of order within the horizon; one with a utime already held replaces it.
  /// A utime more than the horizon before the newest starts anew: the clock was set, or a log
  /// began again. One that is not plausible (time_range.h) is left out.
  void Add(int64_t utime, const Pose& T_world_camera);

  /// Pose at `utime`, interpolated; nothing outside what is known or across a gap.
  [[nodiscard]] std::optional<Pose> At(int64_t utime) const;
  /// True when poses cover [utime - window_us, utime + window_us] without a gap and stay within
  /// the rest limits of the pose at utime.
  [[nodiscard]] bool RestsAt(int64_t utime, int64_t window_us) const;
  /// utime of the newest pose; nothing when empty.
  [[nodiscard]] std::optional<int64_t> Newest() const;

 private:
  struct Entry {
    int64_t utime;
    Eigen::Vector3d translation;
    Eigen::Quaterniond rotation;
  };

  Parameters parameters_;
  std::deque<Entry> entries_;  // By utime.
};

}  // namespace vantage
