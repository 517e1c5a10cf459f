#pragma once

#include <array>
#include <span>
#include <vector>

#include "common/simd.h"
#include "common/triangle_mesh.h"
#include "perception/depth_noise.h"

namespace vantage {

/// Sampled points of a scene as the refinement on points reads them: eight at a time.
class ScenePoints {
 public:
  /// Eight points in the camera's coordinates. What fills the last block up has no normal.
  struct Block {
    F8s<3> position;  ///< m
    F8s<3> normal;    ///< unit, towards the camera
    F8 variance;      ///< m^2, of the position along the normal
  };

  /// Takes the place of what was there; points that are not finite are left out. Allocates nothing
  /// where as many were there before.
  /// @param focal px
  void Assign(std::span<const SurfacePoint> points, double focal, const DepthNoise& noise);

  [[nodiscard]] std::span<const Block> blocks() const { return blocks_; }
  [[nodiscard]] size_t size() const { return size_; }

 private:
  std::vector<Block> blocks_;
  size_t size_ = 0;
};

}  // namespace vantage
