#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <vector>

#include "common/triangle_mesh.h"
#include "perception/ppf/pair_features.h"

namespace vantage {

/// Tells quickly how well surface points lie on a model: a grid of cubes, each with how near the
/// model's surface is and which way its normals point there.
class SurfaceScore {
 public:
  /// @param points of the model, as dense as `spacing`, m.
  /// @param reach m; what is farther from the surface doesn't count.
  /// @param cell m, side of a cube.
  SurfaceScore(std::span<const SurfacePoint> points, double spacing, double reach, double cell);

  /// Sum over `points` of 1 - (distance to the surface / reach)^2, of those that are nearer than
  /// the reach and whose normals agree, to within about 45 deg.
  [[nodiscard]] float Score(const Eigen::Isometry3f& T_object_camera,
                            const SurfaceLanes& points) const;

 private:
  void Stamp(const SurfacePoint& point, double spacing, double reach);

  Eigen::Vector3f origin_;
  float cell_;
  Eigen::Array3i size_;
  std::vector<uint32_t> cells_;  // Low 8 bits: nearness; above: a bit per sector of directions.
};

}  // namespace vantage
