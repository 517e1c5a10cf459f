#pragma once

#include <vector>

#include "common/camera_model.h"
#include "common/lens_distortion.h"
#include "perception/calibration/calibration_target.h"
#include "simulated_pose_views.h"

namespace vantage {

struct SimulatedImageRequest {
  HandEyeSetup setup = HandEyeSetup::kEyeInHand;
  CalibrationTarget target = {};
  int views = 12;
  int outliers = 0;          ///< first views, whose hands are off by 30 mm and 10 deg
  double distance = 0.45;    ///< m
  double tilt = 0.5;         ///< rad, largest
  double robot_scale = 1.0;  ///< true length by what the robot tells
  HandEyeNoise noise = {};   ///< of robot and pixels, that the views have
  CameraModel camera{
      .width = 640, .height = 480, .fx = 600.0, .fy = 605.0, .cx = 322.0, .cy = 238.0};
  LensDistortion distortion = {};
};

/// Image views with their truth.
struct SimulatedImageViews {
  Pose T_x = Pose::Identity();
  Pose T_y = Pose::Identity();
  std::vector<Pose> T_base_hand;      ///< without noise
  std::vector<Pose> T_camera_target;  ///< without noise
  std::vector<ImageView> views;
};

/// The target in the middle of the image, turned and tilted at random; the hand is where the
/// equation puts it.
inline SimulatedImageViews SimulateImageViews(const SimulatedImageRequest& request, Rng& rng) {
  SimulatedImageViews made;
  made.T_x = MakePose(rng.Rotation(), 0.15 * rng.UnitVector());
  made.T_y = MakePose(rng.Rotation(), 0.4 * rng.UnitVector());
  for (int i = 0; i < request.views; ++i) {
    const Eigen::Vector3d axis = rng.UnitVector();
    const Eigen::Quaterniond turn = ExpSo3(rng.Uniform(0.2, 1.0) * request.tilt *
                                           Eigen::Vector3d(axis.x(), axis.y(), 0.0).normalized()) *
                                    ExpSo3({0.0, 0.0, rng.Uniform(-1.5, 1.5)});
    const Eigen::Vector3d place(
        0.03 * rng.Normal(), 0.03 * rng.Normal(), request.distance * rng.Uniform(0.8, 1.2));
    const Pose B = MakePose(turn, place);
    const Pose A = made.T_y * B.inverse() * made.T_x.inverse();
    const Pose hand = request.setup == HandEyeSetup::kEyeInHand ? A : A.inverse();
    made.T_camera_target.push_back(B);
    made.T_base_hand.push_back(hand);
    ImageView view;
    view.name = "view " + std::to_string(i);
    const bool is_outlier = i < request.outliers;
    view.T_base_hand = Disturbed(hand,
                                 is_outlier ? 10.0 * kDegree : request.noise.robot_rotation,
                                 is_outlier ? 0.03 : request.noise.robot_translation,
                                 rng);
    view.T_base_hand.translation() /= request.robot_scale;
    for (const Eigen::Vector3d& p_target : TargetPoints(request.target)) {
      const Eigen::Vector3d p = B * p_target;
      const Eigen::Vector2d seen =
          request.distortion.Distort(Eigen::Vector2d(p.x() / p.z(), p.y() / p.z()));
      const double du = rng.Normal();
      const Eigen::Vector2d noise = request.noise.pixel * Eigen::Vector2d(du, rng.Normal());
      view.points.push_back({p_target,
                             Eigen::Vector2d(request.camera.fx * seen.x() + request.camera.cx,
                                             request.camera.fy * seen.y() + request.camera.cy) +
                                 noise});
    }
    made.views.push_back(std::move(view));
  }
  return made;
}

/// Of an estimate: rotation vector r with truth = exp(r) estimate (rad), translation (m).
inline Eigen::Matrix<double, 6, 1> PoseError(const Pose& estimate, const Pose& truth) {
  Eigen::Matrix<double, 6, 1> error;
  error << LogSo3(Eigen::Quaterniond(truth.linear() * estimate.linear().transpose())),
      truth.translation() - estimate.translation();
  return error;
}

}  // namespace vantage
