#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <vector>

#include "common/triangle_mesh.h"

namespace vantage {

/// The nearest of fixed surface points to any place near them, from a grid of cubes in constant
/// time: exact for the middle of a cube, and up to half its diagonal worse elsewhere.
class NearestGrid {
 public:
  static constexpr uint32_t kNone = 0xffffffffU;

  /// @param reach m; places farther than this from all points have no nearest.
  /// @param cell m, side of a cube.
  NearestGrid(std::vector<SurfacePoint> points, double reach, double cell);

  /// Index of the nearest point, or kNone.
  [[nodiscard]] uint32_t Find(const Eigen::Vector3f& place) const;
  [[nodiscard]] std::span<const SurfacePoint> points() const { return points_; }

 private:
  std::vector<SurfacePoint> points_;
  Eigen::Vector3f origin_;
  float inverse_cell_;
  Eigen::Array3i size_;
  std::vector<uint32_t> nearest_;
};

}  // namespace vantage
