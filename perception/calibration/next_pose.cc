#include "perception/calibration/next_pose.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "perception/calibration/pose_adjustment.h"

namespace vantage {
namespace {

using Covariance12 = Eigen::Matrix<double, 12, 12>;
using Jacobian = Eigen::Matrix<double, 6, 12>;

constexpr double kMargin = 8.0;               // px; a target is not found at the image's very edge
constexpr double kSteepest = 70.0 * kDegree;  // rad; nor at a greater slant

bool IsInImage(const Eigen::Vector3d& p_camera, const CameraModel& camera) {
  if (p_camera.z() <= 0.0) return false;
  const Eigen::Vector2d pixel = camera.Project(p_camera);
  return pixel.x() >= kMargin && pixel.y() >= kMargin && pixel.x() <= camera.width - 1 - kMargin &&
         pixel.y() <= camera.height - 1 - kMargin;
}

bool SeesTarget(const Pose& T_camera_target,
                const CameraModel& camera,
                std::span<const Eigen::Vector3d> points) {
  const Eigen::Vector3d middle = T_camera_target.translation();
  if (!IsInImage(middle, camera)) return false;
  // The target's z goes into it.
  const double cosine = T_camera_target.linear().col(2).dot(middle.normalized());
  return cosine >= std::cos(kSteepest) &&
         std::ranges::all_of(points, [&](const Eigen::Vector3d& p_target) {
           return IsInImage(T_camera_target * p_target, camera);
         });
}

/// Of the pose that the points' pixels give, as PoseView::covariance.
HandEyeCovariance PoseCovariance(const Pose& T_camera_target,
                                 const CameraModel& camera,
                                 std::span<const Eigen::Vector3d> points,
                                 double pixel_sigma) {
  HandEyeCovariance information = HandEyeCovariance::Zero();
  for (const Eigen::Vector3d& p_target : points) {
    const Eigen::Vector3d p = T_camera_target * p_target;
    const Eigen::Vector3d arm = T_camera_target.linear() * p_target;
    Eigen::Matrix<double, 2, 3> by_point;
    by_point << camera.fx, 0.0, -camera.fx * p.x() / p.z(), 0.0, camera.fy,
        -camera.fy * p.y() / p.z();
    by_point /= p.z();
    Eigen::Matrix3d turn;  // d p by a rotation vector
    turn << 0.0, arm.z(), -arm.y(), -arm.z(), 0.0, arm.x(), arm.y(), -arm.x(), 0.0;
    Eigen::Matrix<double, 2, 6> J;
    J << by_point * turn, by_point;
    information += J.transpose() * J / (pixel_sigma * pixel_sigma);
  }
  return information.ldlt().solve(HandEyeCovariance::Identity());
}

HandEyeCovariance CameraCovariance(const Pose& T_camera_target,
                                   const CameraModel& camera,
                                   std::span<const Eigen::Vector3d> points,
                                   const HandEyeNoise& noise) {
  if (points.size() >= 4) {
    return PoseCovariance(T_camera_target, camera, points, noise.pixel);
  }
  Eigen::Matrix<double, 6, 1> sigmas;
  sigmas << Eigen::Vector3d::Constant(noise.camera_rotation),
      Eigen::Vector3d::Constant(noise.camera_translation);
  return sigmas.cwiseAbs2().asDiagonal();
}

/// The covariance of X and Y together after one more view: a Kalman update, which bears priors
/// that know nothing of a direction, or all.
Covariance12 After(const Covariance12& before, const Jacobian& J, double noise_scale) {
  const Eigen::Matrix<double, 12, 6> PJ = before * J.transpose();
  const HandEyeCovariance innovation =
      J * PJ + noise_scale * noise_scale * HandEyeCovariance::Identity();
  return before - PJ * innovation.llt().solve(PJ.transpose());
}

}  // namespace

std::vector<NextPose> RankNextPoses(const HandEyeResult& calibration,
                                    std::span<const Pose> T_base_hand_candidates,
                                    const CameraModel& camera,
                                    std::span<const Eigen::Vector3d> target_points,
                                    const HandEyeNoise& noise,
                                    double lever) {
  Covariance12 before;
  before << calibration.covariance, calibration.cross_covariance,
      calibration.cross_covariance.transpose(), calibration.target_covariance;
  AdjustmentProblem problem;
  problem.setup = calibration.setup;
  problem.noise.robot_rotation = noise.robot_rotation;
  problem.noise.robot_translation = noise.robot_translation;
  AdjustmentState state;
  state.transforms = {calibration.T_x, calibration.T_y};
  std::vector<NextPose> ranked;
  for (size_t i = 0; i < T_base_hand_candidates.size(); ++i) {
    const Pose& T_base_hand = T_base_hand_candidates[i];
    const Pose A = EquationOfHand(calibration.setup, T_base_hand);
    const Pose B = (A * calibration.T_x).inverse(Eigen::Isometry) * calibration.T_y;
    NextPose next{.candidate = i, .sees_target = SeesTarget(B, camera, target_points)};
    Covariance12 after = before;
    if (next.sees_target) {
      AdjustmentView view;
      view.T_base_hand = T_base_hand;
      view.T_camera_target = B;
      view.camera_covariance = CameraCovariance(B, camera, target_points, noise);
      const Jacobian J = Linearize(problem, std::span(&view, 1), state).jacobian;
      after = After(before, J, calibration.noise_scale);
    }
    next.expected_sigma = std::sqrt(std::max(
        0.0,
        lever * lever * after.topLeftCorner<3, 3>().trace() + after.block<3, 3>(3, 3).trace()));
    ranked.push_back(next);
  }
  std::ranges::stable_sort(ranked, [](const NextPose& a, const NextPose& b) {
    if (a.sees_target != b.sees_target) return a.sees_target;
    return a.sees_target && a.expected_sigma < b.expected_sigma;
  });
  return ranked;
}

}  // namespace vantage
