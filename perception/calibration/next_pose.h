#pragma once

#include <span>
#include <vector>

#include "common/camera_model.h"
#include "perception/calibration/hand_eye.h"

namespace vantage {

/// What one more view from a pose would tell.
struct NextPose {
  size_t candidate = 0;      ///< index
  bool sees_target = false;  ///< all of the target's points are in the image
  /// m, standard deviation of X after that view: root of the covariance's trace, its rotation times
  /// `lever`.
  double expected_sigma = 0.0;
};

/// Ranks poses of the hand by what X's covariance would be after a view from there, best first;
/// those that would not see the whole target come last.
/// @param target_points m, on the target. @param lever m, what a rotation of 1 rad is held equal
/// to.
std::vector<NextPose> RankNextPoses(const HandEyeResult& calibration,
                                    std::span<const Pose> T_base_hand_candidates,
                                    const CameraModel& camera,
                                    std::span<const Eigen::Vector3d> target_points,
                                    const HandEyeNoise& noise,
                                    double lever = 0.5);

}  // namespace vantage
