#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "common/depth_rasterizer.h"
#include "perception/verification/simd_path.h"
#include "perception/verification/triangle_block.h"

namespace vantage {

/// A mesh, a pose, a camera and the buffers to draw into. Plain numbers, so that the kernels need
/// no inline function of another header.
struct RasterJob {
  const TriangleBlock* blocks;
  size_t num_blocks;
  float R[3][3];            ///< of p_camera = R p_mesh + t
  float t[3];               ///< m
  float camera_in_mesh[3];  ///< m, the camera's place in the mesh's frame
  float faces_camera;       ///< m; planes that have the camera less far before them are not drawn
  bool is_near;             ///< may reach nearer than DepthRasterizer::kNear: clips
  float fx, fy, cx, cy;     ///< px, of the drawn pixels
  int width, height;        ///< drawn pixels
  int stride;               ///< of the buffers' rows; at least width + 8

  float* inverse_depth;   ///< 1/m; all 0 before
  uint32_t* triangles;    ///< winner's id, where inverse_depth is not 0
  float* plane_distance;  ///< m, of the camera from a triangle's plane, by id; negative behind it
};

/// Draws, and returns the pixels that may have been touched. At equal depth the first drawn wins.
PixelWindow Rasterize(const RasterJob& job, SimdPath path);

}  // namespace vantage
