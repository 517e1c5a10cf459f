#pragma once

#include <Eigen/Core>

#include "common/camera_model.h"
#include "common/lens_distortion.h"

namespace vantage {

/// Where a camera with a lens shows a point, and how that depends on what it is calculated from.
struct Reprojection {
  Eigen::Vector2d pixel;
  Eigen::Matrix<double, 2, 3> by_point;       ///< px/m, by p_camera
  Eigen::Matrix<double, 2, 4> by_pinhole;     ///< by fx, fy, cx, cy
  Eigen::Matrix<double, 2, 4> by_distortion;  ///< px, by k1, k2, p1, p2
};

/// @param p_camera m, z > 0.
Reprojection Reproject(const CameraModel& camera,
                       const LensDistortion& distortion,
                       const Eigen::Vector3d& p_camera);

}  // namespace vantage
