#pragma once

#include <vector>

#include "common/so3.h"
#include "perception/calibration/hand_eye.h"

namespace vantage {

/// How far a robot may go from where it stands while it calibrates.
struct HandPoseLimits {
  double distance = 0.3;         ///< m, of the hand from its start
  double turn = 60.0 * kDegree;  ///< rad, of the hand from its start
};

/// Poses of the hand from which the camera sees the target at several slants, rolls and distances,
/// in a fixed order; those within the limits alone.
/// @param T_x, T_y as in HandEyeResult, roughly. @param distance m, at which the target is seen
/// now.
std::vector<Pose> HandPoseCandidates(HandEyeSetup setup,
                                     const Pose& T_x,
                                     const Pose& T_y,
                                     double distance,
                                     const Pose& T_base_start,
                                     const HandPoseLimits& limits);

/// The first poses, of which nothing is known but that the target is seen from the start: turns of
/// the hand in place about its axes, by `angle` (rad) forth and back.
std::vector<Pose> FirstHandPoses(const Pose& T_base_start, double angle);

}  // namespace vantage
