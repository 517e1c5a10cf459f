#pragma once

#include <Eigen/Core>

#include "common/result.h"

namespace vantage {

/// A pinhole camera: x right, y down, z forward; pixel (0, 0) is a pixel's centre.
struct CameraModel {
  int width = 640;     ///< px
  int height = 480;    ///< px
  double fx = 570.34;  ///< px
  double fy = 570.34;  ///< px
  double cx = 319.5;   ///< px
  double cy = 239.5;   ///< px

  /// Size in 1..16384 px, focal lengths in 1..1e6 px, principal point within 1e6 px of 0.
  Result<void> Validate() const;

  /// p_camera (m, z > 0) to pixel coordinates.
  [[nodiscard]] Eigen::Vector2d Project(const Eigen::Vector3d& p_camera) const {
    return {fx * p_camera.x() / p_camera.z() + cx, fy * p_camera.y() / p_camera.z() + cy};
  }
  /// Pixel coordinates and depth along z (m) to p_camera (m).
  [[nodiscard]] Eigen::Vector3d Unproject(double u, double v, double depth) const {
    return {(u - cx) / fx * depth, (v - cy) / fy * depth, depth};
  }
  /// The same view at another resolution; `factor` > 0 multiplies width and height (0.5 halves).
  [[nodiscard]] CameraModel Scaled(double factor) const;

  bool operator==(const CameraModel&) const = default;
};

/// A pinhole camera from its fields of view (rad) as OpenNI2 reports them, centred.
CameraModel CameraFromFieldOfView(int width, int height, double horizontal, double vertical);

}  // namespace vantage
