#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "common/camera_intrinsics.h"
#include "common/so3.h"

namespace vantage {

/// An inclined floor, a wall, spheres and a plate in the air, in the depth camera's frame; what a
/// camera sees of them follows from equations, ray by ray.
class TracedScene {
 public:
  /// Point that a ray meets first; p = start + t direction, t > 0.
  [[nodiscard]] std::optional<Eigen::Vector3d> Trace(const Eigen::Vector3d& start,
                                                     const Eigen::Vector3d& direction) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Sphere& sphere : kSpheres) {
      const Eigen::Vector3d to = start - sphere.center;
      const double a = direction.squaredNorm();
      const double b = direction.dot(to);
      const double c = to.squaredNorm() - sphere.radius * sphere.radius;
      if (b * b < a * c) continue;
      const double t = (-b - std::sqrt(b * b - a * c)) / a;
      if (t > 0.0) nearest = std::min(nearest, t);
    }
    for (const Plane& plane : kPlanes) {
      const double t = (plane.offset - plane.normal.dot(start)) / plane.normal.dot(direction);
      if (t > 0.0 && IsOn(plane, start + t * direction)) nearest = std::min(nearest, t);
    }
    if (!std::isfinite(nearest)) return std::nullopt;
    return start + nearest * direction;
  }

  /// Depth along the camera's axis of every pixel, m; 0: none.
  [[nodiscard]] std::vector<double> Render(const CameraIntrinsics& intrinsics,
                                           const Pose& T_camera_depth) const {
    const Pose T_depth_camera = T_camera_depth.inverse();
    const CameraModel& camera = intrinsics.camera;
    std::vector<double> depths;
    for (int v = 0; v < camera.height; ++v) {
      for (int u = 0; u < camera.width; ++u) {
        const Eigen::Vector2d shown((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy);
        const auto ideal = intrinsics.distortion.Undistort(shown);
        std::optional<Eigen::Vector3d> point;
        if (ideal) {
          const Eigen::Vector3d direction = T_depth_camera.linear() * ideal->homogeneous();
          point = Trace(T_depth_camera.translation(), direction);
        }
        depths.push_back(point ? (T_camera_depth * *point).z() : 0.0);
      }
    }
    return depths;
  }

 private:
  struct Sphere {
    Eigen::Vector3d center;
    double radius;
  };
  struct Plane {
    Eigen::Vector3d normal;
    double offset;
    double extent;  // m, along x and y from (0.15, -0.1)
  };

  static bool IsOn(const Plane& plane, const Eigen::Vector3d& point) {
    return std::max(std::abs(point.x() - 0.15), std::abs(point.y() + 0.1)) <= plane.extent;
  }

  const std::array<Sphere, 2> kSpheres = {Sphere{{-0.12, 0.05, 0.75}, 0.1},
                                          Sphere{{0.1, 0.12, 0.9}, 0.07}};
  const std::array<Plane, 3> kPlanes = {
      Plane{
          Eigen::Vector3d(0.05, 1.0, 0.35).normalized(), 0.62, 10.0},  // Falls towards the camera.
      Plane{Eigen::Vector3d(0.2, 0.0, 1.0), 1.9, 10.0},
      Plane{Eigen::Vector3d(0.0, 0.3, 1.0), 0.6, 0.07}};
};

/// Whole mm, as a depth camera tells.
inline std::vector<uint16_t> ToMillimetres(const std::vector<double>& metres) {
  std::vector<uint16_t> millimetres;
  for (const double depth : metres) {
    millimetres.push_back(static_cast<uint16_t>(std::lround(1e3 * std::min(depth, 65.0))));
  }
  return millimetres;
}

}  // namespace vantage
