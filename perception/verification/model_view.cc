#include "perception/verification/model_view.h"

#include <algorithm>
#include <cmath>

namespace vantage {

void ModelView::Render(const DrawableMesh& mesh,
                       const Pose& T_camera_mesh,
                       const CameraModel& camera,
                       const PixelWindow& window,
                       int step) {
  step_ = step;
  touched_ = PixelWindow{};
  rasterizer_.reset();
  const auto first = [step](int pixel) { return (std::max(pixel, 0) + step - 1) / step * step; };
  u0_ = first(window.u0);
  v0_ = first(window.v0);
  const int u1 = std::min(window.u1, camera.width - 1);
  const int v1 = std::min(window.v1, camera.height - 1);
  if (window.empty() || u1 < u0_ || v1 < v0_) return;
  width_ = (u1 - u0_) / step + 1;
  height_ = (v1 - v0_) / step + 1;
  CameraModel part;
  part.width = width_;
  part.height = height_;
  part.fx = camera.fx / step;
  part.fy = camera.fy / step;
  part.cx = (camera.cx - u0_) / step;
  part.cy = (camera.cy - v0_) / step;
  rasterizer_.emplace(part);
  touched_ = rasterizer_->Draw(mesh.mesh(), T_camera_mesh);
}

bool ModelView::Shows(int u, int v, int margin) const {
  if (empty() || u < u0_ - margin || v < v0_ - margin) return false;
  const int reach = margin / step_;
  const int i = (u - u0_) / step_;
  const int j = (v - v0_) / step_;
  const std::span<const float> depth = rasterizer_->depth();
  for (int dj = -reach; dj <= reach; ++dj) {
    for (int di = -reach; di <= reach; ++di) {
      if (i + di < 0 || j + dj < 0 || i + di >= width_ || j + dj >= height_) continue;
      if (depth[static_cast<size_t>((j + dj) * width_ + i + di)] != DepthRasterizer::kEmpty) {
        return true;
      }
    }
  }
  return false;
}

PixelWindow BallWindow(const CameraModel& camera, const Eigen::Vector3d& p_camera, double radius) {
  const double nearest = p_camera.z() - radius;
  if (!(nearest > static_cast<double>(DepthRasterizer::kNear)) || !(p_camera.z() < 1e3)) return {};
  // The ball's image lies within that of its bounding cube.
  PixelWindow window{camera.width, camera.height, -1, -1};
  for (const double z : {nearest, p_camera.z() + radius}) {
    for (const double sign : {-1.0, 1.0}) {
      const Eigen::Vector2d pixel =
          camera.Project({p_camera.x() + sign * radius, p_camera.y() + sign * radius, z});
      const double u = std::clamp(pixel.x(), -1e6, 1e6);
      const double v = std::clamp(pixel.y(), -1e6, 1e6);
      window.u0 = std::min(window.u0, static_cast<int>(std::floor(u)));
      window.v0 = std::min(window.v0, static_cast<int>(std::floor(v)));
      window.u1 = std::max(window.u1, static_cast<int>(std::ceil(u)));
      window.v1 = std::max(window.v1, static_cast<int>(std::ceil(v)));
    }
  }
  window.u0 = std::max(window.u0, 0);
  window.v0 = std::max(window.v0, 0);
  window.u1 = std::min(window.u1, camera.width - 1);
  window.v1 = std::min(window.v1, camera.height - 1);
  return window;
}

PixelWindow ModelWindow(const CameraModel& camera,
                        const ModelShape& model,
                        const Pose& T_camera_object) {
  return BallWindow(camera, T_camera_object * model.center, model.radius);
}

Eigen::Vector3f VisibleNormal(const DrawableMesh& mesh,
                              const Eigen::Matrix3f& R_camera_mesh,
                              uint32_t triangle,
                              const Eigen::Vector3f& ray) {
  const Eigen::Vector3f normal = R_camera_mesh * mesh.normal(triangle);
  return normal.dot(ray) > 0.0F ? Eigen::Vector3f(-normal) : normal;
}

}  // namespace vantage
