#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/camera_model.h"
#include "common/lens_distortion.h"
#include "common/so3.h"

namespace vantage {

/// Where the camera is fixed. What is sought is X, what comes with it is Y; A X B = Y for every
/// view, with B = T_camera_target:
///   eye in hand: A = T_base_hand, X = T_hand_camera, Y = T_base_target;
///   eye to hand: A = T_base_hand^-1, X = T_base_camera, Y = T_hand_target.
enum class HandEyeSetup { kEyeInHand, kEyeToHand };

using HandEyeCovariance = Eigen::Matrix<double, 6, 6>;

/// Where the hand was when the camera saw the target somewhere.
struct PoseView {
  std::string name;   ///< for people: a file, a line, a time
  int64_t utime = 0;  ///< us since the epoch, of the image; 0: not known
  Pose T_base_hand = Pose::Identity();
  Pose T_camera_target = Pose::Identity();
  /// Poses that explain the image about as well: a flat target seen from afar has two (Collins,
  /// Bartoli, "Infinitesimal Plane-Based Pose Estimation", IJCV 2014).
  std::vector<Pose> other_T_camera_target = {};
  /// Of the error of T_camera_target: rotation vector (rad), translation (m), both in the camera's
  /// axes; nothing: that of HandEyeNoise.
  std::optional<HandEyeCovariance> covariance = std::nullopt;
};

/// A point of the target where an image shows it.
struct TargetPoint {
  Eigen::Vector3d p_target = Eigen::Vector3d::Zero();  ///< m
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();     ///< px; (0, 0) is a pixel's centre
};

/// Where the hand was when the camera took an image of the target.
struct ImageView {
  std::string name;
  int64_t utime = 0;  ///< us since the epoch; 0: not known
  Pose T_base_hand = Pose::Identity();
  std::vector<TargetPoint> points;
};

/// Standard deviations of what is measured. The result's covariance is scaled by what the residuals
/// say; the ratio of these weighs robot against camera.
struct HandEyeNoise {
  double robot_rotation = 0.02 * kDegree;  ///< rad, about each axis
  double robot_translation = 0.0001;       ///< m, along each axis
  double camera_rotation = 0.1 * kDegree;  ///< rad, about each axis, of a pose of the target
  double camera_translation = 0.0005;      ///< m, along each axis
  double pixel = 0.2;                      ///< px, along each axis, of a point in an image
};

/// How far a view is from what the calibration says.
struct ViewResidual {
  std::string name;
  double rotation = 0.0;     ///< rad, of A X B against Y
  double translation = 0.0;  ///< m
  double pixels = 0.0;       ///< px, root mean square; 0 where no images are given
  double deviation =
      0.0;  ///< in standard deviations: root of the mean square of whitened residuals
  bool is_outlier = false;  ///< left out of the result
  /// rad and m, the same with a calibration from the other views; not for outliers.
  double left_out_rotation = 0.0;
  double left_out_translation = 0.0;
};

/// How well the motions fix X.
struct Observability {
  /// Singular values of the whitened problem, largest first, in the scale of 1 mm and 0.1 deg:
  /// reciprocals of standard deviations along the directions that X's error may have.
  Eigen::Matrix<double, 6, 1> singular_values = Eigen::Matrix<double, 6, 1>::Zero();
  /// rad, spread of the hand's orientations about the three principal axes, largest first; the
  /// second one must stand out of the noise.
  Eigen::Vector3d rotation_spread = Eigen::Vector3d::Zero();
  bool is_sufficient = false;
  std::string reason;  ///< why not, and what to do: "... add views rotated about another axis"
};

struct HandEyeResult {
  HandEyeSetup setup = HandEyeSetup::kEyeInHand;
  Pose T_x = Pose::Identity();  ///< X: T_hand_camera or T_base_camera
  Pose T_y = Pose::Identity();  ///< Y: T_base_target or T_hand_target
  /// Of X's error: rotation vector r with true R = exp(r) R (rad), translation (m), both in the
  /// axes of hand or base. Scaled by the residuals.
  HandEyeCovariance covariance = HandEyeCovariance::Zero();
  HandEyeCovariance target_covariance = HandEyeCovariance::Zero();  ///< of Y, alike
  HandEyeCovariance cross_covariance = HandEyeCovariance::Zero();   ///< of X's errors with Y's
  /// The square of the 95 % ellipsoid's radius: error^T covariance^-1 error, with regard to how
  /// many residuals the scale rests on.
  double squared_radius_95 = 12.592;
  double noise_scale = 1.0;  ///< of HandEyeNoise, as the residuals say

  std::vector<ViewResidual> views;  ///< in the order of the input
  double rotation_rms = 0.0;        ///< rad, over the views that are no outliers
  double translation_rms = 0.0;     ///< m
  double left_out_rotation_rms = 0.0;
  double left_out_translation_rms = 0.0;
  Observability observability;
  std::string initial_method;  ///< closed form that the solution started from

  /// Where they were asked for.
  std::optional<double> robot_scale;  ///< true length by length that the robot tells
  std::optional<double> time_offset;  ///< s; the image of utime t shows the hand of t + offset
  double robot_scale_sigma = 0.0;
  double time_offset_sigma = 0.0;  ///< s
  std::optional<CameraModel> camera;
  std::optional<LensDistortion> distortion;
};

}  // namespace vantage
