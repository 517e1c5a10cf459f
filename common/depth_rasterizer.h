#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "common/camera_model.h"
#include "common/so3.h"
#include "common/triangle_mesh.h"

namespace vantage {

/// Inclusive rectangle of pixels; empty when u1 < u0 or v1 < v0.
struct PixelWindow {
  int u0 = 0;
  int v0 = 0;
  int u1 = -1;
  int v1 = -1;

  [[nodiscard]] bool empty() const { return u1 < u0 || v1 < v0; }
  /// px; below 1 when empty.
  [[nodiscard]] int width() const { return u1 - u0 + 1; }
  [[nodiscard]] int height() const { return v1 - v0 + 1; }
  bool operator==(const PixelWindow&) const = default;
};

/// All pixels of a camera.
inline PixelWindow WholeImage(const CameraModel& camera) {
  return {0, 0, camera.width - 1, camera.height - 1};
}

/// Renders triangle meshes into a depth buffer, seen through a pinhole camera. Both sides of a
/// triangle are drawn; where two meshes meet the nearer one wins, at equal depth the first drawn.
class DepthRasterizer {
 public:
  static constexpr float kEmpty = std::numeric_limits<float>::infinity();
  static constexpr uint32_t kNoId = 0xffffffffU;

  explicit DepthRasterizer(const CameraModel& camera);

  /// Empties the buffers for a new image.
  void Clear() { Clear(WholeImage(camera_)); }
  /// For one of which only a window, not empty, is drawn: its pixels are the whole image's.
  void Clear(const PixelWindow& window);
  /// Draws a mesh. Triangles that reach nearer than `kNear` m are clipped there.
  /// @param mesh_id what ids() shall tell of the pixels that it wins.
  /// @return the pixels that it may have touched.
  PixelWindow Draw(const TriangleMesh& mesh, const Pose& T_camera_mesh, uint32_t mesh_id = 0);

  /// Depth along z, m; kEmpty where nothing was drawn. width * height values, of the window if only
  /// one was drawn.
  [[nodiscard]] std::span<const float> depth() const { return {depth_.data(), size_}; }
  /// mesh_id of the pixel's winner, kNoId where nothing was drawn.
  [[nodiscard]] std::span<const uint32_t> mesh_ids() const { return {mesh_ids_.data(), size_}; }
  /// Index of the winner's triangle in its mesh; kNoId where nothing was drawn.
  [[nodiscard]] std::span<const uint32_t> triangle_ids() const {
    return {triangle_ids_.data(), size_};
  }
  [[nodiscard]] const CameraModel& camera() const { return camera_; }

  static constexpr float kNear = 0.05F;  ///< m

 private:
  // A corner of a triangle in the image. 1 / z is affine there, so it is what gets interpolated.
  struct Corner {
    float u, v;  // px
    float w;     // 1/m, of its depth
  };

  [[nodiscard]] Corner Project(const Eigen::Vector3f& p_camera) const;
  void DrawTriangle(const std::array<Corner, 3>& corners,
                    uint32_t mesh_id,
                    uint32_t triangle_id,
                    PixelWindow* touched);

  CameraModel camera_;
  PixelWindow window_;  // The buffers' pixels.
  size_t size_ = 0;     // px, of it; the buffers are longer, so that eight at once can be read.
  std::vector<float> depth_;
  std::vector<uint32_t> mesh_ids_;
  std::vector<uint32_t> triangle_ids_;
  // Reused: vertices of the mesh in hand.
  std::vector<Eigen::Vector3f> p_camera_;
  std::vector<Corner> corners_;
};

}  // namespace vantage
