#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <vector>

#include "common/camera_model.h"
#include "common/depth_rasterizer.h"
#include "common/so3.h"
#include "perception/verification/drawable_mesh.h"
#include "perception/verification/simd_path.h"

namespace vantage {

/// What hypotheses of one model need of it.
struct ModelShape {
  const DrawableMesh& mesh;
  Eigen::Vector3d center;  ///< m
  double diameter;         ///< m
  double radius;           ///< m, of the smallest ball about the center that holds the mesh
};

/// Every `step`-th pixel of a window of a camera's image, drawn with one model in a pose. Allocates
/// nothing once it has drawn as large a window and mesh.
class ModelView {
 public:
  explicit ModelView(SimdPath path = BestSimdPath()) : path_(path) {}

  /// @param window in the camera's pixels; what is outside the image is cut off.
  /// @param step >= 1; only pixels whose u and v are its multiples are drawn.
  void Render(const DrawableMesh& mesh,
              const Pose& T_camera_mesh,
              const CameraModel& camera,
              const PixelWindow& window,
              int step);

  /// One drawn pixel.
  struct Pixel {
    int u;                 ///< px, of the camera's image
    int v;                 ///< px
    float depth;           ///< m, along z
    uint32_t triangle;     ///< an id for DrawableMesh::normal
    float plane_distance;  ///< m >= 0, of the camera from the triangle's plane: of a step of 1 m
                           ///< along the ray's z the part along the normal is this over depth
  };
  /// Calls `visit(Pixel)` for every pixel that shows the model, row by row.
  template <class Visit>
  void ForEachPixel(Visit visit) const {
    for (int j = touched_.v0; j <= touched_.v1; ++j) {
      for (int i = touched_.u0; i <= touched_.u1; ++i) {
        const size_t index = Index(i, j);
        if (inverse_depth_[index] == 0.0F) continue;
        const uint32_t triangle = triangles_[index];
        visit(Pixel{u0_ + i * step_,
                    v0_ + j * step_,
                    1.0F / inverse_depth_[index],
                    triangle,
                    std::abs(plane_distance_[triangle])});
      }
    }
  }
  [[nodiscard]] bool empty() const { return touched_.empty(); }

  /// Drawn pixels that may show the model; pixel (i, j) is the camera's (u0() + i step(),
  /// v0() + j step()).
  [[nodiscard]] const PixelWindow& touched() const { return touched_; }
  [[nodiscard]] int u0() const { return u0_; }
  [[nodiscard]] int v0() const { return v0_; }
  [[nodiscard]] int step() const { return step_; }
  /// Of a drawn pixel, in the buffers; eight values from there on may be read.
  [[nodiscard]] size_t Index(int i, int j) const {
    return static_cast<size_t>(j) * static_cast<size_t>(stride_) + static_cast<size_t>(i);
  }
  [[nodiscard]] size_t stride() const { return static_cast<size_t>(stride_); }
  /// 1/m; 0 where the model is not seen.
  [[nodiscard]] const float* inverse_depth() const { return inverse_depth_.data(); }
  /// Triangles' ids, where inverse_depth() is not 0.
  [[nodiscard]] const uint32_t* triangles() const { return triangles_.data(); }
  /// m, of the camera from the planes of drawn triangles, by id; negative when it is behind.
  [[nodiscard]] const float* plane_distance() const { return plane_distance_.data(); }
  [[nodiscard]] SimdPath path() const { return path_; }

  /// Drawn pixels, row by row: 1 where the model is seen no more than `reach` of them away along
  /// rows and columns. The window may reach over the drawn one. Valid until the next call.
  struct Reached {
    PixelWindow window;
    const uint8_t* pixels;
    [[nodiscard]] const uint8_t* row(int j) const {
      return pixels + static_cast<ptrdiff_t>(j - window.v0) * (window.u1 - window.u0 + 1);
    }
  };
  Reached Reach(int reach);

 private:
  void Clear();

  SimdPath path_;
  std::vector<float> inverse_depth_;  // All 0 but for touched_.
  std::vector<uint32_t> triangles_;
  std::vector<float> plane_distance_;
  std::vector<uint8_t> reached_;  // Scratch of Reach().
  PixelWindow touched_;
  int u0_ = 0;
  int v0_ = 0;
  int step_ = 1;
  int stride_ = 0;
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
