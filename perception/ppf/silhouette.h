#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "perception/ppf/pair_features.h"

namespace vantage {

/// Where scene points are in the camera's view, coarsely: a bitmap over their directions.
class Silhouette {
 public:
  /// Of points in camera coordinates that lie about `spacing` m apart. Allocates nothing once warm.
  void Draw(const SurfaceLanes& scene, float spacing);

  /// How many of `points` the camera would see outside of the silhouette. Few when the object lies
  /// so and nothing hides it.
  [[nodiscard]] int CountOutside(const Eigen::Isometry3f& T_camera_object,
                                 const SurfaceLanes& points) const;

 private:
  static constexpr int kSide = 64;  // Cells; those along the border stay empty.

  float left_ = 0.0F;   // x/z
  float top_ = 0.0F;    // y/z
  float scale_ = 0.0F;  // Cells for 1 of x/z.
  std::vector<uint8_t> cells_;
};

}  // namespace vantage
