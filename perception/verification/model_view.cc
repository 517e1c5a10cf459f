#include "perception/verification/model_view.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/check.h"
#include "common/simd.h"
#include "perception/verification/rasterize.h"

namespace vantage {

namespace {

constexpr int kPadding = 8;  // Kernels load and store eight pixels at once.

// Everything about the mesh, the pose and the camera; not the buffers.
RasterJob MakeJob(const DrawableMesh& mesh, const Pose& T_camera_mesh, const CameraModel& drawn) {
  RasterJob job{};
  job.blocks = mesh.blocks().data();
  job.num_blocks = mesh.blocks().size();
  const Eigen::Matrix3d& R = T_camera_mesh.matrix().topLeftCorner<3, 3>();
  const Eigen::Vector3d& t = T_camera_mesh.translation();
  const Eigen::Vector3d camera_in_mesh = -(R.transpose() * t);
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) job.R[i][k] = static_cast<float>(R(i, k));
    job.t[i] = static_cast<float>(t(i));
    job.camera_in_mesh[i] = static_cast<float>(camera_in_mesh(i));
  }
  const Eigen::Vector3d center = T_camera_mesh * mesh.center();
  constexpr double kMargin = 1e-3;  // m
  job.is_near =
      !(center.z() - mesh.radius() > static_cast<double>(DepthRasterizer::kNear) + kMargin);
  // Backs can be seen where a surface is open, or cut by the near plane. A triangle seen edge-on
  // is drawn, however its plane's distance is rounded.
  constexpr double kRounding = 1e-6;  // Of the distances that go into it.
  job.faces_camera = mesh.is_closed() && !job.is_near
                         ? static_cast<float>(-kRounding * (camera_in_mesh.norm() +
                                                            mesh.center().norm() + mesh.radius()))
                         : -std::numeric_limits<float>::infinity();
  job.fx = static_cast<float>(drawn.fx);
  job.fy = static_cast<float>(drawn.fy);
  job.cx = static_cast<float>(drawn.cx);
  job.cy = static_cast<float>(drawn.cy);
  job.width = drawn.width;
  job.height = drawn.height;
  return job;
}

template <class T>
void GrowTo(size_t size, std::vector<T>* values) {
  if (values->size() < size) values->resize(size);
}

VANTAGE_SIMD void MarkSeen(const float* inverse_depth, size_t count, uint8_t* seen) {
  for (size_t i = 0; i < count; ++i) seen[i] = inverse_depth[i] > 0.0F ? 1 : 0;
}

VANTAGE_SIMD void JoinMarks(const uint8_t* marks, size_t count, uint8_t* joined) {
  for (size_t i = 0; i < count; ++i) joined[i] |= marks[i];
}

}  // namespace

void ModelView::Clear() {
  for (int j = touched_.v0; j <= touched_.v1; ++j) {
    const auto row = inverse_depth_.begin() + static_cast<ptrdiff_t>(Index(0, j));
    std::fill(row + touched_.u0, row + touched_.u1 + 1, 0.0F);
  }
  touched_ = PixelWindow{};
}

void ModelView::Render(const DrawableMesh& mesh,
                       const Pose& T_camera_mesh,
                       const CameraModel& camera,
                       const PixelWindow& window,
                       int step) {
  VANTAGE_CHECK(step >= 1, "step of a view");
  Clear();
  step_ = step;
  const auto first = [step](int pixel, int size) {
    return (std::clamp(pixel, 0, size) + step - 1) / step * step;
  };
  u0_ = first(window.u0, camera.width);
  v0_ = first(window.v0, camera.height);
  const int u1 = std::min(window.u1, camera.width - 1);
  const int v1 = std::min(window.v1, camera.height - 1);
  if (window.empty() || u1 < u0_ || v1 < v0_ || mesh.blocks().empty() ||
      !T_camera_mesh.matrix().allFinite()) {
    return;
  }
  CameraModel drawn;
  drawn.width = (u1 - u0_) / step + 1;
  drawn.height = (v1 - v0_) / step + 1;
  drawn.fx = camera.fx / step;
  drawn.fy = camera.fy / step;
  drawn.cx = (camera.cx - u0_) / step;
  drawn.cy = (camera.cy - v0_) / step;
  RasterJob job = MakeJob(mesh, T_camera_mesh, drawn);
  stride_ = drawn.width + kPadding;
  GrowTo(Index(0, drawn.height), &inverse_depth_);
  GrowTo(Index(0, drawn.height), &triangles_);
  GrowTo(mesh.blocks().size() * TriangleBlock::kLanes, &plane_distance_);
  job.stride = stride_;
  job.inverse_depth = inverse_depth_.data();
  job.triangles = triangles_.data();
  job.plane_distance = plane_distance_.data();
  touched_ = Rasterize(job, path_);
}

ModelView::Reached ModelView::Reach(int reach) {
  if (empty()) return {PixelWindow{}, nullptr};
  const auto margin = static_cast<size_t>(2 * reach);
  const auto seen = static_cast<size_t>(touched_.u1 - touched_.u0 + 1);
  const auto seen_rows = static_cast<size_t>(touched_.v1 - touched_.v0 + 1);
  const size_t columns = seen + margin;
  const size_t rows = seen_rows + margin;
  reached_.assign((rows + 1) * columns + margin, 0);
  uint8_t* row = &reached_[rows * columns];  // One row, with a margin to both sides.
  for (size_t j = 0; j < seen_rows; ++j) {
    const size_t from = Index(touched_.u0, touched_.v0 + static_cast<int>(j));
    MarkSeen(&inverse_depth_[from], seen, row + margin);
    // Along the row, into the last of the rows that it reaches.
    uint8_t* spread = &reached_[(j + margin) * columns];
    for (size_t k = 0; k <= margin; ++k) JoinMarks(row + k, columns, spread);
  }
  // Every row reaches those before: row j is joined from j on, which are not yet changed.
  for (size_t j = 0; j < rows; ++j) {
    for (size_t k = 1; k <= margin && j + k < rows; ++k) {
      JoinMarks(&reached_[(j + k) * columns], columns, &reached_[j * columns]);
    }
  }
  return {{touched_.u0 - reach, touched_.v0 - reach, touched_.u1 + reach, touched_.v1 + reach},
          reached_.data()};
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
