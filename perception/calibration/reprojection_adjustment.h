#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "common/camera_model.h"
#include "common/lens_distortion.h"
#include "perception/calibration/closed_form.h"
#include "perception/calibration/hand_eye.h"
#include "perception/calibration/hand_trajectory.h"

namespace vantage {

/// What is told of a view.
struct ReprojectionView {
  std::span<const TargetPoint> points;
  /// Of each point, 0 to 1: how much its residual counts.
  std::vector<double> weights;
  Pose T_base_hand = Pose::Identity();
  int64_t utime = 0;  ///< us, for the time offset
};

struct ReprojectionProblem {
  HandEyeSetup setup = HandEyeSetup::kEyeInHand;
  bool estimates_robot_scale = false;
  bool estimates_pinhole = false;
  bool estimates_distortion = false;
  /// Asks for the time offset; then views are where it says.
  const HandTrajectory* trajectory = nullptr;
  std::vector<ReprojectionView> views;
  /// What is known of the camera before: far from it, it is not believed.
  CameraModel expected_camera;
};

/// Standard deviations that residuals are whitened by.
struct ReprojectionNoise {
  double pixel = 0.2;              ///< px
  double robot_rotation = 0.0;     ///< rad
  double robot_translation = 0.0;  ///< m
};

/// What is estimated.
struct ReprojectionState {
  HandEyeTransforms transforms;
  double robot_scale = 1.0;
  double time_offset = 0.0;  ///< s
  CameraModel camera;
  LensDistortion distortion;
  std::vector<Pose> T_camera_target;  ///< of each view; stands for the hand's true pose
};

/// What one view says near a state, by the error of T_camera_target (6, as PoseView::covariance),
/// then what all views share: X's error, Y's error (as HandEyeResult::covariance), and as far as
/// asked for robot scale, time offset (s), fx, fy, cx, cy (px), k1, k2, p1, p2. Not whitened.
struct ViewEquations {
  struct Part {
    Eigen::MatrixXd information;  ///< J^T J
    Eigen::VectorXd gradient;     ///< J^T r
    double squared_error = 0.0;   ///< r^T r
  };
  Part pixels;              ///< px
  Part robot_rotation;      ///< rad
  Part robot_translation;   ///< m
  double num_pixels = 0.0;  ///< twice the sum of the points' weights
};

/// One least-squares problem over X, Y, every view's pose and what else is asked for: reprojection
/// errors of all points, and for each view how far the robot's pose is from what X, Y and the
/// view's pose say of it. Returns false where no step was possible.
bool AdjustReprojection(const ReprojectionProblem& problem,
                        const ReprojectionNoise& noise,
                        ReprojectionState* state);

std::vector<ViewEquations> LinearizeReprojection(const ReprojectionProblem& problem,
                                                 const ReprojectionState& state);

/// The state moved by an error of what all views share.
ReprojectionState MovedShared(const ReprojectionProblem& problem,
                              const ReprojectionState& state,
                              const Eigen::VectorXd& step);

/// Information on what all views share that is there before any view: loose bounds on robot scale,
/// time offset and camera, none on X and Y. Diagonal.
Eigen::VectorXd PriorInformation(const ReprojectionProblem& problem);

}  // namespace vantage
