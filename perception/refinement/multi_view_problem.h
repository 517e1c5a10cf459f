#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "common/so3.h"
#include "perception/refinement/motion_equations.h"

namespace vantage {

/// What one view tells about one object: minus its log-likelihood is, but for a constant,
/// m^T information m / 2 - right^T m for a motion m of the object from where it was drawn.
struct ViewTerm {
  size_t object = 0;
  size_t view = 0;
  Pose T_camera_object = Pose::Identity();  ///< as drawn
  /// Of a rotation vector about the model's center (rad) and a translation (m) in the camera's
  /// axes.
  Matrix6 information = Matrix6::Zero();
  Vector6 right = Vector6::Zero();
};

/// What is sought. Motions of cameras are a rotation vector (rad) and a translation (m), in the
/// camera's axes: T_world_camera * (exp(rotation), translation).
struct MultiViewState {
  std::vector<Pose> T_world_object;
  std::vector<Vector6> camera;         ///< of each view's camera from where the robot has it
  Vector6 hand_eye = Vector6::Zero();  ///< of all cameras, before that of each
  /// Of the sensor, the same in all views: depth tilts about the camera's x and y (rad) at the
  /// object's center, and shifts (m at 1 m, growing with the depth's square).
  Eigen::Vector3d bias = Eigen::Vector3d::Zero();

  /// Of a view, as adjusted.
  [[nodiscard]] Pose Camera(size_t view, const Pose& T_world_camera) const;
};

/// Several objects in several views.
struct MultiViewProblem {
  std::span<const Pose> T_world_camera;  ///< as the robot tells
  std::vector<Eigen::Vector3d> centers;  ///< m, of the models, in their frames
  std::vector<Pose> T_world_object_start;
  std::vector<ViewTerm> terms;
  /// Standard deviations about 0: six numbers each of a rotation and a translation; 0: fixed.
  double camera_rotation = 0.0, camera_translation = 0.0;
  double hand_eye_rotation = 0.0, hand_eye_translation = 0.0;
  double bias_tilt = 0.0, bias_at_1m = 0.0;
};

/// The most likely state by Ceres: a block of six residuals for each term and each prior.
/// @param state where to begin; takes the solution.
/// @param covariances if not null: of the objects' errors, rotation vector (rad) and translation of
///   the center (m) in the world's axes.
/// @return false where it failed; the state is then as it was.
bool SolveMultiView(const MultiViewProblem& problem,
                    MultiViewState* state,
                    std::vector<Matrix6>* covariances);

/// Minus the log-likelihood of a state, and its derivative by motions of the objects about their
/// centers in the world's axes and by the cameras' motions, six numbers each.
double MultiViewCost(const MultiViewProblem& problem,
                     const MultiViewState& state,
                     std::vector<Vector6>* by_objects,
                     std::vector<Vector6>* by_cameras);

}  // namespace vantage
