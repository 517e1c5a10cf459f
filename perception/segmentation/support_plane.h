#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "common/result.h"
#include "common/rng.h"

namespace vantage {

/// A large plane of the scene: points with normal . p = offset; the normal points towards the side
/// of the camera.
struct SupportPlane {
  Eigen::Vector3d normal = -Eigen::Vector3d::UnitZ();
  double offset = 0.0;                ///< m, negative: the camera is on the positive side
  bool carries = true;                ///< Objects stand on it; false: a wall.
  std::vector<Eigen::Vector2d> hull;  ///< m, convex, counter-clockwise, in (axis_x, axis_y)
  Eigen::Vector3d axis_x = Eigen::Vector3d::UnitX();
  Eigen::Vector3d axis_y = Eigen::Vector3d::UnitY();

  /// Signed distance, m, positive towards the camera.
  [[nodiscard]] double Height(const Eigen::Vector3d& p_camera) const {
    return normal.dot(p_camera) - offset;
  }
  [[nodiscard]] Eigen::Vector2d Along(const Eigen::Vector3d& p_camera) const {
    return {axis_x.dot(p_camera), axis_y.dot(p_camera)};
  }
  /// True when the foot of `p_camera` is inside the hull or at most `margin` m outside.
  [[nodiscard]] bool IsAboveHull(const Eigen::Vector3d& p_camera, double margin) const;
};

struct SupportPlaneParameters {
  int iterations = 300;        ///< at most, of RANSAC (Fischler, Bolles 1981), of each plane
  double inlier_sigmas = 3.0;  ///< a point within this many sigmas of noise belongs to the plane
  double min_extent = 0.25;    ///< m; a plane of smaller extent is a face of an object
  double min_share = 0.2;      ///< [0, 1] of all points; a quarter of it past the first plane
  int max_planes = 3;          ///< that are looked for
  /// px between the points that are looked at; 0: an 80th of the image's width. For windows of an
  /// image, whose points shall not lie denser than the image's.
  int grid_px = 0;
  Result<void> Validate() const;
};

/// Makes `points` their convex hull, counter-clockwise, without collinear points (Andrew 1979).
/// @param hull a buffer, reused.
void ConvexHull(std::vector<Eigen::Vector2d>* points, std::vector<Eigen::Vector2d>* hull);

}  // namespace vantage
