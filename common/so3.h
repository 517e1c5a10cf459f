#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <span>

#include "common/result.h"

namespace vantage {

/// A rigid transform. Named so that inner names cancel: p_world = T_world_camera * p_camera.
using Pose = Eigen::Isometry3d;

inline constexpr double kDegree = 0.017453292519943295;  ///< rad

/// The one way in for quaternions from outside (messages, files, users).
/// @param wxyz in the order of the wire.
/// Errors: not finite, or norm farther than `tolerance` from 1. The result has unit norm.
Result<Eigen::Quaterniond> QuaternionFromWire(std::span<const double, 4> wxyz,
                                              double tolerance = 1e-3);

/// A rigid transform from outside: m, and a quaternion w, x, y, z. Errors as QuaternionFromWire,
/// and translations that are not finite or longer than 1e6 m.
Result<Pose> PoseFromWire(std::span<const double, 3> trans, std::span<const double, 4> wxyz);

/// Nearest rotation (Frobenius norm) to a 3x3 matrix from outside.
/// Errors: not finite, or farther than `tolerance` from a rotation in any singular value.
Result<Eigen::Matrix3d> ProjectToRotation(const Eigen::Matrix3d& matrix, double tolerance = 0.05);

/// Angle of the rotation between two orientations, rad in [0, pi]. Same for q and -q; exact to
/// rounding near 0 and pi (paper section 5.1, d_q).
double GeodesicAngle(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b);

/// Rotation by |rotation_vector| rad about its direction.
Eigen::Quaterniond ExpSo3(const Eigen::Vector3d& rotation_vector);
/// Inverse of ExpSo3, of length in [0, pi].
Eigen::Vector3d LogSo3(const Eigen::Quaterniond& q);

/// Of q and -q the one with w > 0 (at w = 0: first non-zero of z, y, x positive).
Eigen::Quaterniond Canonical(const Eigen::Quaterniond& q);

/// Camera pose (x right, y down, z forward) at `eye` looking at `target`, image up along `up` as
/// far as possible. `eye` != `target`; any up is used when `up` is parallel to the view.
Pose LookAt(const Eigen::Vector3d& eye,
            const Eigen::Vector3d& target,
            const Eigen::Vector3d& up = Eigen::Vector3d::UnitZ());

}  // namespace vantage
