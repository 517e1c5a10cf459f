#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "common/so3.h"

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

/// The orientation of a camera turned by the smallest rotation that brings a point onto its optical
/// axis. What a camera sees of an object beside its axis depends on where it looks from, not on
/// where the object is in its image: directions and differences are those of the camera aimed so.
/// @param p_world m, not the camera's own place.
inline Eigen::Quaterniond AimedAt(const Pose& T_world_camera, const Eigen::Vector3d& p_world) {
  const Eigen::Vector3d axis = T_world_camera.linear().col(2);
  const Eigen::Vector3d ray = p_world - T_world_camera.translation();
  return (Eigen::Quaterniond::FromTwoVectors(axis, ray) *
          Eigen::Quaterniond(T_world_camera.linear()))
      .normalized();
}

}  // namespace vantage
