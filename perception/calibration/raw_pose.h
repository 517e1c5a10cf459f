#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "common/result.h"
#include "common/so3.h"

namespace vantage {

/// A pose as it was written down, with the numbers as they stand there: what they were meant to be
/// is not always what they are read as.
struct RawPose {
  enum class Rotation {
    kQuaternion,      ///< w, x, y, z
    kRotationVector,  ///< x, y, z, rad
    kMatrix,          ///< row by row
  };

  Eigen::Vector3d translation = Eigen::Vector3d::Zero();  ///< m
  Rotation kind = Rotation::kQuaternion;
  std::array<double, 9> rotation = {1.0};  ///< the first 4, 3 or 9 count
};

/// A pair of poses as it was written down.
struct RawView {
  std::string name;   ///< for people: a file and line, an index
  int64_t utime = 0;  ///< us since the epoch; 0: not known
  RawPose hand;       ///< T_base_hand
  RawPose camera;     ///< T_camera_target
};

/// Errors: numbers that are not finite; translations beyond 1e6 m; a quaternion whose norm is not
/// 1 within 1e-3; a rotation vector longer than a turn; a matrix that is no rotation, above all a
/// mirroring one (determinant -1).
Result<Pose> PoseFromRaw(const RawPose& raw);

/// As a matrix.
RawPose RawFromPose(const Pose& pose);

}  // namespace vantage
