#pragma once

#include <Eigen/LU>
#include <vector>

#include "common/rng.h"
#include "common/so3.h"
#include "perception/calibration/hand_eye.h"

namespace vantage {

inline Pose MakePose(const Eigen::Quaterniond& q, const Eigen::Vector3d& t) {
  Pose pose = Pose::Identity();
  pose.linear() = q.toRotationMatrix();
  pose.translation() = t;
  return pose;
}

/// Pose views with their truth.
struct SimulatedPoseViews {
  HandEyeSetup setup = HandEyeSetup::kEyeInHand;
  Pose T_x = Pose::Identity();
  Pose T_y = Pose::Identity();
  std::vector<Pose> T_base_hand;  ///< without noise
  std::vector<PoseView> views;
  std::vector<bool> is_outlier;
};

struct SimulatedPoseRequest {
  HandEyeSetup setup = HandEyeSetup::kEyeInHand;
  int views = 30;
  double outlier_share = 0.0;
  HandEyeNoise noise;                        ///< that the views have
  Eigen::Vector3d turns = {0.5, 0.5, 0.5};   ///< rad, of the hand about its axes
  Eigen::Vector3d travel = {0.3, 0.3, 0.3};  ///< m, half of the hand's workspace
};

inline Eigen::Vector3d NormalVector(double sigma, Rng& rng) {
  const double x = rng.Normal();
  const double y = rng.Normal();
  return sigma * Eigen::Vector3d(x, y, rng.Normal());
}

/// A pose with an error: rotation about its origin and translation.
inline Pose Disturbed(const Pose& pose, double rotation, double translation, Rng& rng) {
  Pose disturbed = pose;
  disturbed.linear() = ExpSo3(NormalVector(rotation, rng)) * pose.linear();
  disturbed.translation() += NormalVector(translation, rng);
  return disturbed;
}

/// The hand turns about fixed mean axes and moves in a box; camera and target are where the
/// equation puts them.
inline SimulatedPoseViews SimulatePoseViews(const SimulatedPoseRequest& request, Rng& rng) {
  SimulatedPoseViews made;
  made.setup = request.setup;
  made.T_x = MakePose(rng.Rotation(), 0.15 * rng.UnitVector());
  const Pose mean = MakePose(rng.Rotation(), 0.5 * rng.UnitVector());
  const bool in_hand = request.setup == HandEyeSetup::kEyeInHand;
  if (!in_hand) made.T_x.translation() += 0.8 * rng.UnitVector();
  for (int i = 0; i < request.views; ++i) {
    const Eigen::Vector3d turn = request.turns.cwiseProduct(NormalVector(1.0, rng));
    const Eigen::Vector3d step(rng.Uniform(-1, 1), rng.Uniform(-1, 1), rng.Uniform(-1, 1));
    made.T_base_hand.push_back(mean * MakePose(ExpSo3(turn), request.travel.cwiseProduct(step)));
  }
  // The target lies some 0.6 m from the camera's mean place, or 0.1 m from the hand.
  made.T_y = in_hand ? mean * made.T_x * MakePose(rng.Rotation(), 0.6 * rng.UnitVector())
                     : MakePose(rng.Rotation(), 0.1 * rng.UnitVector());
  const int num_outliers = static_cast<int>(request.outlier_share * request.views + 0.5);
  for (int i = 0; i < request.views; ++i) {
    const Pose& hand = made.T_base_hand[static_cast<size_t>(i)];
    const Pose A = in_hand ? hand : hand.inverse();
    PoseView view;
    view.name = "view " + std::to_string(i);
    const bool is_outlier = i < num_outliers;
    made.is_outlier.push_back(is_outlier);
    view.T_camera_target = Disturbed((A * made.T_x).inverse() * made.T_y,
                                     is_outlier ? 10.0 * kDegree : request.noise.camera_rotation,
                                     is_outlier ? 0.03 : request.noise.camera_translation,
                                     rng);
    view.T_base_hand =
        Disturbed(hand, request.noise.robot_rotation, request.noise.robot_translation, rng);
    made.views.push_back(view);
  }
  return made;
}

/// Error of a transform as HandEyeResult::covariance has it: rotation vector, translation.
inline Eigen::Matrix<double, 6, 1> ErrorOf(const Pose& estimate, const Pose& truth) {
  Eigen::Matrix<double, 6, 1> error;
  error << LogSo3(Eigen::Quaterniond(truth.linear() * estimate.linear().transpose())),
      truth.translation() - estimate.translation();
  return error;
}

/// The least covariance of X that an unbiased estimate may have (Cramer, Rao): inverse of the full
/// Fisher information at the truth, with all true poses of the hand as unknowns, measured by the
/// robot and seen by the camera. Derivatives by central differences.
inline HandEyeCovariance CramerRaoBound(const SimulatedPoseViews& truth,
                                        const HandEyeNoise& noise) {
  const auto num_hands = static_cast<Eigen::Index>(truth.T_base_hand.size());
  const Eigen::Index size = 12 + 6 * num_hands;
  const bool in_hand = truth.setup == HandEyeSetup::kEyeInHand;
  const auto moved = [](const Pose& pose, int axis, double step) {
    Pose result = pose;
    if (axis < 3) {
      result.linear() = ExpSo3(step * Eigen::Vector3d::Unit(axis)) * pose.linear();
    } else {
      result.translation()[axis - 3] += step;
    }
    return result;
  };
  const auto seen = [in_hand](const Pose& hand, const Pose& x, const Pose& y) {
    return ((in_hand ? hand : hand.inverse()) * x).inverse() * y;
  };
  constexpr double kStep = 1e-6;
  Eigen::Matrix<double, 6, 1> camera_sigma;
  camera_sigma << Eigen::Vector3d::Constant(noise.camera_rotation),
      Eigen::Vector3d::Constant(noise.camera_translation);
  Eigen::Matrix<double, 6, 1> robot_sigma;
  robot_sigma << Eigen::Vector3d::Constant(noise.robot_rotation),
      Eigen::Vector3d::Constant(noise.robot_translation);
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(size, size);
  for (Eigen::Index i = 0; i < num_hands; ++i) {
    const Pose& hand = truth.T_base_hand[static_cast<size_t>(i)];
    Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(6, size);
    for (int axis = 0; axis < 6; ++axis) {
      for (int which = 0; which < 3; ++which) {
        const auto at = [&](double step) {
          return seen(which == 2 ? moved(hand, axis, step) : hand,
                      which == 0 ? moved(truth.T_x, axis, step) : truth.T_x,
                      which == 1 ? moved(truth.T_y, axis, step) : truth.T_y);
        };
        const Eigen::Index column = which == 2 ? 12 + 6 * i + axis : 6 * which + axis;
        jacobian.col(column) = ErrorOf(at(-kStep), at(kStep)) / (2.0 * kStep);
      }
    }
    jacobian = camera_sigma.cwiseInverse().asDiagonal() * jacobian;
    information += jacobian.transpose() * jacobian;
    for (int axis = 0; axis < 6; ++axis) {
      information(12 + 6 * i + axis, 12 + 6 * i + axis) +=
          1.0 / (robot_sigma[axis] * robot_sigma[axis]);
    }
  }
  return information.inverse().topLeftCorner<6, 6>();
}

}  // namespace vantage
