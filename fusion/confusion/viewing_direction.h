#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace vantage {

/// v = -R_camera_object^T z: the direction from the object to the camera along the optical axis, in
/// the object's frame. Rolls of the camera about its axis don't change it.
inline Eigen::Vector3d ViewingDirection(const Eigen::Quaterniond& q_camera_object) {
  return -(q_camera_object.conjugate() * Eigen::Vector3d::UnitZ());
}

/// The orientation of an object that is seen from `direction`, the camera rolled by `roll` rad from
/// some fixed way to hold it: ViewingDirection(OrientationSeenFrom(v, roll)) = v.
/// @param direction of norm 1.
inline Eigen::Quaterniond OrientationSeenFrom(const Eigen::Vector3d& direction, double roll) {
  return Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ()) *
         Eigen::Quaterniond::FromTwoVectors(direction, -Eigen::Vector3d::UnitZ());
}

}  // namespace vantage
