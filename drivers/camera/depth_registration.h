#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/camera_intrinsics.h"
#include "common/so3.h"
#include "drivers/camera/ray_projection.h"

namespace vantage {

/// Depth images as another camera, the color camera, would have taken them. Every depth pixel is a
/// small piece of a surface, as large and as inclined as its nearer neighbors tell, and the nearest
/// piece wins. So images of different resolutions have no holes, slanted surfaces have no steps,
/// and between near and far nothing is invented.
class DepthRegistration {
 public:
  /// @param depth of the depth images as they will be given
  /// @param color an ideal camera, that of undistorted color images
  DepthRegistration(const CameraIntrinsics& depth,
                    const CameraModel& color,
                    const Pose& T_color_depth);

  /// @param depth_mm row by row along the depth camera's axis, 0: no measurement
  /// @param registered gets the color camera's size, along its axis; 0: nothing seen there
  void Register(std::span<const uint16_t> depth_mm, std::vector<uint16_t>* registered);

  [[nodiscard]] const CameraModel& color() const { return color_; }

 private:
  // A row of the depth image in the color image, a value more at both ends that is far.
  struct Row {
    std::vector<float> u;  // px
    std::vector<float> v;  // px
    std::vector<float> z;  // mm
  };
  // What the pixels of a row cover: (u0, v0) to (u1, v1), nothing if u1 < u0 or v1 < v0. There the
  // depth is `z` at (u0, v0), and grows by `z_u` and `z_v` a pixel.
  struct Pieces {
    std::vector<int32_t> u0, v0, u1, v1;
    std::vector<float> z, z_u, z_v;
  };

  void ProjectRow(std::span<const uint16_t> depth_mm, int row);
  void FindPieces(int row);
  void Draw(uint16_t* image) const;

  CameraModel color_;
  RayProjection projection_;
  float spacing_;            // px, between depth pixels in the color image
  std::array<Row, 3> rows_;  // Row i is at i mod 3.
  Pieces pieces_;
};

}  // namespace vantage
