#pragma once

#include <cstddef>
#include <cstdint>

namespace vantage {

/// Up to eight neighboring triangles over up to eight vertices, a lane each, so that drawing them
/// loads nothing by index: the layout of a DrawableMesh.
struct alignas(32) TriangleBlock {
  static constexpr size_t kLanes = 8;

  /// Planes normal . p = offset, m; outward unit normals. Lanes without a triangle: offset
  /// infinite.
  float normal[3][kLanes];
  float offset[kLanes];
  float vertex[3][kLanes];    ///< m, x's, then y's, then z's
  uint8_t corner[3][kLanes];  ///< lanes of `vertex`, counter-clockwise seen from outside
};

}  // namespace vantage
