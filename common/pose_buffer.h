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
    int64_t horizon_us = 10'000'000;  ///< us; older poses are forgotten
    /// us; no interpolation across a longer silence, and no pose comes later than this after its
    /// successors
    int64_t largest_gap_us = 200'000;
    double rest_translation = 0.0005;      ///< m; at rest if it moved less than this
    double rest_rotation = 0.1 * kDegree;  ///< rad; and turned less than this
  };

  PoseBuffer() = default;
  explicit PoseBuffer(const Parameters& parameters) : parameters_(parameters) {}

  /// Poses may come out of order by up to the largest gap; one with a utime already held replaces
  /// it. A utime farther before the newest starts anew: the clock was set, or a log began again,
  /// and the poses of both passes are not to be mixed. One that is not plausible (time_range.h) is
  /// left out.
  /// @return true when it started anew: what was known of earlier times is void.
  bool Add(int64_t utime, const Pose& T_world_camera);

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
