#pragma once

#include <vector>

#include "common/rng.h"
#include "perception/calibration/hand_eye.h"

namespace vantage {

/// How the hand moves between views.
enum class HandEyeMotion {
  kGeneric,   ///< tilts by up to 40 deg, rolls by up to 90 deg, moves in a box of 0.4 m
  kOneAxis,   ///< rolls and moves
  kWobble,    ///< alike, and tilts by 0.2 deg
  kNoTurn,    ///< moves only
  kSamePose,  ///< stands still
};

struct HandEyeSimulation {
  HandEyeSetup setup = HandEyeSetup::kEyeInHand;
  HandEyeMotion motion = HandEyeMotion::kGeneric;
  int views = 30;
  double outlier_share = 0.0;
  HandEyeNoise noise;  ///< that the views have
  /// Of an outlier's T_camera_target, instead of the camera's noise.
  double outlier_rotation = 10.0 * kDegree;  ///< rad, about each axis
  double outlier_translation = 0.03;         ///< m, along each axis
};

/// Views with their truth.
struct SimulatedHandEye {
  HandEyeSetup setup = HandEyeSetup::kEyeInHand;
  Pose T_x = Pose::Identity();
  Pose T_y = Pose::Identity();
  std::vector<Pose> T_base_hand;  ///< without noise
  std::vector<PoseView> views;
  std::vector<bool> is_outlier;  ///< drawn
};

/// A camera 0.1 m from the hand looks at a target 0.5 m away, or one beside the robot looks at a
/// target 0.1 m from the hand, over 0.8 m.
SimulatedHandEye SimulateHandEye(const HandEyeSimulation& simulation, Rng& rng);

/// Rotation vector and translation from an estimate to the truth, as HandEyeResult::covariance.
Eigen::Matrix<double, 6, 1> HandEyeError(const Pose& estimate, const Pose& truth);

/// The least covariance of X that an unbiased estimate can have that knows which views are
/// outliers: the inverse of the Fisher information at the truth, where robot and camera measure and
/// the true poses of the hand are unknown too (Cramer, Rao).
HandEyeCovariance HandEyeCramerRaoBound(const SimulatedHandEye& truth, const HandEyeNoise& noise);

}  // namespace vantage
