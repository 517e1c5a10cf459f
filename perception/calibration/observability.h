#pragma once

#include <span>

#include "perception/calibration/hand_eye.h"

namespace vantage {

/// Judges whether the motions of the hand fix X: rotations about at least two axes are needed
/// (Tsai, Lenz 1989; Chen 1991), and what they leave open is named.
/// @param T_base_hand of the views used. @param covariance of X, as HandEyeResult::covariance.
/// @param robot_rotation rad, noise of T_base_hand.
Observability AssessObservability(HandEyeSetup setup,
                                  std::span<const Pose> T_base_hand,
                                  const HandEyeCovariance& covariance,
                                  double robot_rotation);

}  // namespace vantage
