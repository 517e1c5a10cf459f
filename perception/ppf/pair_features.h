#pragma once

#include <span>
#include <vector>

#include "common/triangle_mesh.h"

namespace vantage {

/// Surface points coordinate by coordinate, padded to whole vectors by points far away.
struct SurfaceLanes {
  size_t size = 0;  ///< without the padding
  std::vector<float> x, y, z;
  std::vector<float> normal_x, normal_y, normal_z;

  /// Allocates nothing once it has held as many.
  void Assign(std::span<const SurfacePoint> points);
  void Clear();
  void Add(const SurfacePoint& point);
  void Pad();
  [[nodiscard]] SurfacePoint at(size_t i) const;
};

/// Point pair features (paper eq. 1) of one reference point with many others, and the turns of
/// these about its normal.
struct PairFeatures {
  std::vector<float> distance;       ///< m
  std::vector<float> angle_normal1;  ///< rad
  std::vector<float> angle_normal2;  ///< rad
  std::vector<float> angle_normals;  ///< rad
  std::vector<float> turn;           ///< rad, AngleAboutX
};

/// ComputePointPairFeature and AngleAboutX of all `points`, to within 2e-4 rad.
void ComputePairFeatures(const SurfacePoint& reference,
                         const SurfaceLanes& points,
                         PairFeatures* features);

}  // namespace vantage
