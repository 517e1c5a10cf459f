#include "tools/evaluate/handeye_simulation.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "common/format.h"

namespace vantage {
namespace {

using Eigen::Vector3d;
using Vector6d = Eigen::Matrix<double, 6, 1>;

constexpr double kTilt = 40.0 * kDegree;
constexpr double kRoll = 90.0 * kDegree;
constexpr double kWobble = 0.2 * kDegree;
constexpr double kTravel = 0.2;  // m, half of the box
constexpr double kDifference = 1e-6;

Pose MakePose(const Eigen::Quaterniond& q, const Vector3d& t) {
  Pose pose = Pose::Identity();
  pose.linear() = q.toRotationMatrix();
  pose.translation() = t;
  return pose;
}

Vector3d UniformVector(double largest, Rng& rng) {
  const double x = rng.Uniform(-largest, largest);
  const double y = rng.Uniform(-largest, largest);
  return {x, y, rng.Uniform(-largest, largest)};
}

Pose Disturbed(const Pose& pose, double rotation, double translation, Rng& rng) {
  const auto normal = [&rng](double sigma) {
    const double x = rng.Normal();
    const double y = rng.Normal();
    return Vector3d(sigma * Vector3d(x, y, rng.Normal()));
  };
  Pose disturbed = pose;
  disturbed.linear() = ExpSo3(normal(rotation)) * pose.linear();
  disturbed.translation() += normal(translation);
  return disturbed;
}

/// From the mean pose of the hand, about its axes.
Pose HandMotion(HandEyeMotion motion, Rng& rng) {
  const double tilt = motion == HandEyeMotion::kGeneric  ? kTilt
                      : motion == HandEyeMotion::kWobble ? kWobble
                                                         : 0.0;
  const bool rolls = motion != HandEyeMotion::kNoTurn && motion != HandEyeMotion::kSamePose;
  const double x = rng.Uniform(-tilt, tilt);
  const double y = rng.Uniform(-tilt, tilt);
  const double roll = rolls ? rng.Uniform(-kRoll, kRoll) : 0.0;
  const Vector3d step = UniformVector(motion == HandEyeMotion::kSamePose ? 0.0 : kTravel, rng);
  return MakePose(ExpSo3({x, y, 0.0}) * ExpSo3({0.0, 0.0, roll}), step);
}

/// What the camera sees.
Pose Seen(HandEyeSetup setup, const Pose& T_base_hand, const Pose& T_x, const Pose& T_y) {
  const Pose A = setup == HandEyeSetup::kEyeInHand ? T_base_hand : T_base_hand.inverse();
  return (A * T_x).inverse() * T_y;
}

Pose Moved(const Pose& pose, int axis, double step) {
  Pose moved = pose;
  if (axis < 3) {
    moved.linear() = ExpSo3(step * Vector3d::Unit(axis)) * pose.linear();
  } else {
    moved.translation()[axis - 3] += step;
  }
  return moved;
}

Vector6d Variances(double rotation, double translation) {
  Vector6d variances;
  variances << Vector3d::Constant(rotation * rotation),
      Vector3d::Constant(translation * translation);
  return variances;
}

}  // namespace

SimulatedHandEye SimulateHandEye(const HandEyeSimulation& simulation, Rng& rng) {
  SimulatedHandEye made;
  made.setup = simulation.setup;
  const bool in_hand = simulation.setup == HandEyeSetup::kEyeInHand;
  // The hand points down before the robot; the camera's error of mounting is any.
  const Pose mean = MakePose(ExpSo3({180.0 * kDegree, 0.0, 0.0}) * ExpSo3(UniformVector(0.3, rng)),
                             Vector3d(0.5, 0.0, 0.5) + UniformVector(0.1, rng));
  if (in_hand) {
    made.T_x = MakePose(rng.Rotation(), 0.1 * rng.UnitVector());
    made.T_y = mean * MakePose(rng.Rotation(), Vector3d(0.0, 0.0, 0.5) + UniformVector(0.05, rng));
  } else {
    made.T_x = LookAt(mean.translation() + 0.8 * rng.UnitVector(), mean.translation());
    made.T_y = MakePose(rng.Rotation(), 0.1 * rng.UnitVector());
  }
  const int num_outliers =
      static_cast<int>(simulation.outlier_share * static_cast<double>(simulation.views) + 0.5);
  for (int i = 0; i < simulation.views; ++i) {
    const Pose T_base_hand = mean * HandMotion(simulation.motion, rng);
    const bool is_outlier = i < num_outliers;
    const HandEyeNoise& noise = simulation.noise;
    PoseView view;
    view.name = Format("view %d", i);
    view.T_camera_target =
        Disturbed(Seen(simulation.setup, T_base_hand, made.T_x, made.T_y),
                  is_outlier ? simulation.outlier_rotation : noise.camera_rotation,
                  is_outlier ? simulation.outlier_translation : noise.camera_translation,
                  rng);
    view.T_base_hand = Disturbed(T_base_hand, noise.robot_rotation, noise.robot_translation, rng);
    made.T_base_hand.push_back(T_base_hand);
    made.views.push_back(view);
    made.is_outlier.push_back(is_outlier);
  }
  return made;
}

Vector6d HandEyeError(const Pose& estimate, const Pose& truth) {
  Vector6d error;
  error << LogSo3(Eigen::Quaterniond(truth.linear() * estimate.linear().transpose())),
      truth.translation() - estimate.translation();
  return error;
}

HandEyeCovariance HandEyeCramerRaoBound(const SimulatedHandEye& truth, const HandEyeNoise& noise) {
  const Vector6d camera = Variances(noise.camera_rotation, noise.camera_translation);
  const Vector6d robot = Variances(noise.robot_rotation, noise.robot_translation);
  Eigen::Matrix<double, 12, 12> information = Eigen::Matrix<double, 12, 12>::Zero();
  for (size_t i = 0; i < truth.T_base_hand.size(); ++i) {
    if (truth.is_outlier[i]) continue;
    // Derivatives of what the camera sees by X, Y and the hand.
    Eigen::Matrix<double, 6, 18> jacobian;
    for (int axis = 0; axis < 18; ++axis) {
      const auto seen = [&](double step) {
        Pose poses[] = {truth.T_x, truth.T_y, truth.T_base_hand[i]};
        poses[axis / 6] = Moved(poses[axis / 6], axis % 6, step);
        return Seen(truth.setup, poses[2], poses[0], poses[1]);
      };
      jacobian.col(axis) =
          HandEyeError(seen(-kDifference), seen(kDifference)) / (2.0 * kDifference);
    }
    // The hand's true pose marginalized: the robot's noise as the camera sees it.
    const Eigen::Matrix<double, 6, 6> by_hand = jacobian.rightCols<6>();
    HandEyeCovariance covariance = by_hand * robot.asDiagonal() * by_hand.transpose();
    covariance.diagonal() += camera;
    const Eigen::Matrix<double, 6, 12> by_sought = jacobian.leftCols<12>();
    information += by_sought.transpose() * covariance.ldlt().solve(by_sought);
  }
  return information.inverse().topLeftCorner<6, 6>();
}

}  // namespace vantage
