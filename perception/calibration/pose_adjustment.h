#pragma once

#include <Eigen/Core>
#include <span>

#include "perception/calibration/closed_form.h"
#include "perception/calibration/hand_eye.h"

namespace vantage {

/// A view as it is adjusted.
struct AdjustmentView {
  Pose T_base_hand = Pose::Identity();
  /// How T_base_hand changes with the time offset, in the base's axes: rad/s, m/s.
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  Pose T_camera_target = Pose::Identity();
  /// Of T_camera_target, as PoseView::covariance.
  HandEyeCovariance camera_covariance = HandEyeCovariance::Identity();
};

/// What is estimated.
struct AdjustmentState {
  HandEyeTransforms transforms;
  double robot_scale = 1.0;
  double time_offset = 0.0;  ///< s, from the time that T_base_hand is of
};

/// By how much all rotations and all translations are noisier than robot and camera claim.
struct ResidualScales {
  double rotation = 1.0;
  double translation = 1.0;
};

/// How views are weighed. The robot's error is a rotation about the hand's origin and a translation
/// of it, alike in all directions.
struct AdjustmentNoise {
  double robot_rotation = 0.0;     ///< rad
  double robot_translation = 0.0;  ///< m
  ResidualScales scales;
};

struct AdjustmentProblem {
  HandEyeSetup setup = HandEyeSetup::kEyeInHand;
  AdjustmentNoise noise;
  bool estimates_robot_scale = false;
  bool estimates_time_offset = false;
};

/// The residual of A X B = Y: rotation vector of R_A R_X R_B R_Y^T (rad), translation of A X B less
/// that of Y (m).
Eigen::Matrix<double, 6, 1> ViewError(HandEyeSetup setup,
                                      const AdjustmentView& view,
                                      const AdjustmentState& state);

/// Covariance of ViewError() by the noise of robot and camera, J_A S_robot J_A^T + J_B S_camera
/// J_B^T: errors in variables to first order (Fuller, "Measurement Error Models", 1987).
HandEyeCovariance ViewErrorCovariance(const AdjustmentProblem& problem,
                                      const AdjustmentView& view,
                                      const AdjustmentState& state);

/// Whitened residuals of all views, six each, first three of the rotation alone, and their
/// derivatives by what is estimated: X's error, Y's error (rotation vector, translation, as
/// HandEyeResult::covariance), then robot scale and time offset where they are estimated.
struct AdjustmentLinearization {
  Eigen::VectorXd residuals;
  Eigen::MatrixXd jacobian;
};

AdjustmentLinearization Linearize(const AdjustmentProblem& problem,
                                  std::span<const AdjustmentView> views,
                                  const AdjustmentState& state);

/// The state that minimizes the residuals, whitened by their covariances at the start: those change
/// with lever arms alone, so that a start from a solution settles them.
AdjustmentState AdjustPoses(const AdjustmentProblem& problem,
                            std::span<const AdjustmentView> views,
                            const AdjustmentState& start);

/// The state moved by an error as Linearize() has it.
AdjustmentState Moved(const AdjustmentProblem& problem,
                      const AdjustmentState& state,
                      const Eigen::VectorXd& step);

}  // namespace vantage
