#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "common/camera_model.h"
#include "common/depth_rasterizer.h"
#include "common/so3.h"
#include "perception/verification/drawable_mesh.h"

namespace vantage {

/// What hypotheses of one model need of it.
struct ModelShape {
  const DrawableMesh& mesh;
  Eigen::Vector3d center;  ///< m
  double diameter;         ///< m
  double radius;           ///< m, of the smallest ball about the center that holds the mesh
};

/// Every `step`-th pixel of a window of a camera's image, drawn with one model in a pose.
class ModelView {
 public:
  /// @param window in the camera's pixels; what is outside the image is cut off.
  /// @param step >= 1; only pixels whose u and v are its multiples are drawn.
  void Render(const DrawableMesh& mesh,
              const Pose& T_camera_mesh,
              const CameraModel& camera,
              const PixelWindow& window,
              int step);

  /// One drawn pixel.
  struct Pixel {
    int u;        ///< px, of the camera's image
    int v;        ///< px
    float depth;  ///< m
    uint32_t triangle;
  };
  /// Calls `visit(Pixel)` for every pixel that shows the model, row by row.
  template <class Visit>
  void ForEachPixel(Visit visit) const {
    if (empty()) return;
    const std::span<const float> depth = rasterizer_->depth();
    const std::span<const uint32_t> triangles = rasterizer_->triangle_ids();
    for (int j = touched_.v0; j <= touched_.v1; ++j) {
      for (int i = touched_.u0; i <= touched_.u1; ++i) {
        const size_t index = static_cast<size_t>(j * width_ + i);
        if (depth[index] == DepthRasterizer::kEmpty) continue;
        visit(Pixel{u0_ + i * step_, v0_ + j * step_, depth[index], triangles[index]});
      }
    }
  }
  /// True when the drawn pixel nearest below (u, v), or one at most `margin` px away, shows the
  /// model.
  [[nodiscard]] bool Shows(int u, int v, int margin) const;
  [[nodiscard]] bool empty() const { return !rasterizer_ || touched_.empty(); }

 private:
  std::optional<DepthRasterizer> rasterizer_;
  PixelWindow touched_;  // In drawn pixels.
  int u0_ = 0;
  int v0_ = 0;
  int step_ = 1;
  int width_ = 0;
  int height_ = 0;
};

/// Pixels in which a ball may be seen, cut to the image; empty when it is outside or not wholly in
/// front of the camera.
PixelWindow BallWindow(const CameraModel& camera, const Eigen::Vector3d& p_camera, double radius);

/// Where a model in a pose may be seen.
PixelWindow ModelWindow(const CameraModel& camera,
                        const ModelShape& model,
                        const Pose& T_camera_object);

/// Outward unit normal of a triangle in camera coordinates, turned towards the camera.
/// @param ray line of sight, p_camera = depth * ray.
Eigen::Vector3f VisibleNormal(const DrawableMesh& mesh,
                              const Eigen::Matrix3f& R_camera_mesh,
                              uint32_t triangle,
                              const Eigen::Vector3f& ray);

}  // namespace vantage
