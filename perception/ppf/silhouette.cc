#include "perception/ppf/silhouette.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "common/simd.h"

namespace vantage {
namespace {

constexpr float kNearest = 1e-3F;  // m; what is nearer has no direction

[[gnu::always_inline]] inline void Load(const float* from, F8* to) {
  std::memcpy(to, from, sizeof(F8));
}

}  // namespace

void Silhouette::Draw(const SurfaceLanes& scene, float spacing) {
  cells_.assign(kSide * kSide, 0);
  Eigen::AlignedBox2f box;
  float nearest = 1e9F;
  for (size_t i = 0; i < scene.size; ++i) {
    if (!(scene.z[i] > kNearest)) continue;
    box.extend(Eigen::Vector2f(scene.x[i], scene.y[i]) / scene.z[i]);
    nearest = std::min(nearest, scene.z[i]);
  }
  scale_ = 0.0F;
  if (box.isEmpty()) return;
  const float margin = spacing / nearest;
  scale_ = (kSide - 4) / (box.sizes().maxCoeff() + 2.0F * margin);
  left_ = box.min().x() - margin - 2.0F / scale_;
  top_ = box.min().y() - margin - 2.0F / scale_;
  for (size_t i = 0; i < scene.size; ++i) {
    if (!(scene.z[i] > kNearest)) continue;
    const float u = (scene.x[i] / scene.z[i] - left_) * scale_;
    const float v = (scene.y[i] / scene.z[i] - top_) * scale_;
    const float reach = 0.8F * spacing / scene.z[i] * scale_;
    const int u0 = std::max(1, static_cast<int>(u - reach));
    const int u1 = std::min(kSide - 2, static_cast<int>(u + reach));
    const int v0 = std::max(1, static_cast<int>(v - reach));
    const int v1 = std::min(kSide - 2, static_cast<int>(v + reach));
    for (int row = v0; row <= v1; ++row) {
      for (int column = u0; column <= u1; ++column) {
        cells_[static_cast<size_t>(row * kSide + column)] = 1;
      }
    }
  }
}

VANTAGE_SIMD
int Silhouette::CountOutside(const Eigen::Isometry3f& T_camera_object,
                             const SurfaceLanes& points) const {
  const Eigen::Matrix3f R = T_camera_object.linear();
  const Eigen::Vector3f t = T_camera_object.translation();
  constexpr float kTop = kSide - 1;
  const F8 zero = {};
  int inside = 0;
  for (size_t i = 0; i + kLanes <= points.x.size(); i += kLanes) {
    F8 x, y, z;
    Load(&points.x[i], &x);
    Load(&points.y[i], &y);
    Load(&points.z[i], &z);
    const F8 depth = R(2, 0) * x + R(2, 1) * y + R(2, 2) * z + t.z();
    const F8 scale = scale_ / (depth > kNearest ? depth : zero + kNearest);
    F8 u = (R(0, 0) * x + R(0, 1) * y + R(0, 2) * z + t.x()) * scale - left_ * scale_;
    F8 v = (R(1, 0) * x + R(1, 1) * y + R(1, 2) * z + t.y()) * scale - top_ * scale_;
    u = u > 0.0F ? (u < kTop ? u : zero) : zero;
    v = v > 0.0F ? (v < kTop ? v : zero) : zero;
    const I8 index = __builtin_convertvector(v, I8) * kSide + __builtin_convertvector(u, I8);
    for (int k = 0; k < kLanes; ++k) inside += cells_[static_cast<size_t>(index[k])];
  }
  return static_cast<int>(points.size) - inside;
}

}  // namespace vantage
