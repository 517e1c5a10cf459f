#include "perception/calibration/hand_pose_candidates.h"

#include "perception/calibration/closed_form.h"

namespace vantage {
namespace {

using Eigen::AngleAxisd;
using Eigen::Vector3d;

/// Poses of the target before the camera, its middle on the optical axis.
std::vector<Pose> TargetPoses(double distance) {
  constexpr double kSlants[] = {0.0, 15.0, 30.0, 45.0};         // deg
  constexpr double kRolls[] = {-90.0, -45.0, 0.0, 45.0, 90.0};  // deg
  constexpr double kDistances[] = {0.75, 1.0, 1.3};             // by the present one
  constexpr int kDirections = 8;
  std::vector<Pose> poses;
  for (const double slant : kSlants) {
    for (int i = 0; i < (slant == 0.0 ? 1 : kDirections); ++i) {
      const double direction = 360.0 * i / kDirections * kDegree;
      const AngleAxisd tilt(slant * kDegree,
                            Vector3d(std::cos(direction), std::sin(direction), 0.0));
      for (const double roll : kRolls) {
        for (const double share : kDistances) {
          poses.push_back(Eigen::Translation3d(0.0, 0.0, share * distance) * tilt *
                          AngleAxisd(roll * kDegree, Vector3d::UnitZ()));
        }
      }
    }
  }
  return poses;
}

}  // namespace

std::vector<Pose> HandPoseCandidates(HandEyeSetup setup,
                                     const Pose& T_x,
                                     const Pose& T_y,
                                     double distance,
                                     const Pose& T_base_start,
                                     const HandPoseLimits& limits) {
  const Eigen::Quaterniond q_start(T_base_start.linear());
  // The target's axes as the start sees them: rolls and slants are about those.
  const Pose A_start = EquationOfHand(setup, T_base_start);
  const Pose B_start = (A_start * T_x).inverse(Eigen::Isometry) * T_y;
  const Vector3d facing = B_start.linear().col(2);
  const Eigen::Matrix3d untilt =
      Eigen::Quaterniond::FromTwoVectors(facing, Vector3d::UnitZ()).toRotationMatrix();
  const Eigen::Matrix3d upright = untilt * B_start.linear();
  std::vector<Pose> candidates;
  for (Pose T_camera_target : TargetPoses(distance)) {
    T_camera_target.linear() = T_camera_target.linear() * upright;
    const Pose A = T_y * (T_x * T_camera_target).inverse(Eigen::Isometry);
    const Pose T_base_hand = EquationOfHand(setup, A);
    const double moved = (T_base_hand.translation() - T_base_start.translation()).norm();
    const double turned = GeodesicAngle(Eigen::Quaterniond(T_base_hand.linear()), q_start);
    if (moved <= limits.distance && turned <= limits.turn) candidates.push_back(T_base_hand);
  }
  return candidates;
}

std::vector<Pose> FirstHandPoses(const Pose& T_base_start, double angle) {
  std::vector<Pose> poses;
  for (const double sign : {1.0, -1.0}) {
    for (const int axis : {0, 1, 2}) {
      poses.push_back(T_base_start * AngleAxisd(sign * angle, Vector3d::Unit(axis)));
    }
  }
  return poses;
}

}  // namespace vantage
