#include "common/depth_rasterizer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "common/check.h"
#include "common/simd.h"

namespace vantage {
namespace {

// Which pixels a triangle may cover, and what its barycentric weights and its depth are there.
struct Triangle {
  int u0, v0, u1, v1;            // Inclusive.
  float u, v;                    // px, of corner a
  float b_du, b_dv, c_du, c_dv;  // Weights of b and c are affine in (u, v).
  float a_w, b_w, c_w;           // 1/m, inverse depths: affine in the image, too.
  uint32_t mesh_id, id;
};

// The buffers at a triangle's first pixel.
struct Target {
  float* depth;
  uint32_t* mesh_ids;
  uint32_t* triangle_ids;
  size_t stride;  // px, of rows; as many pixels as there are lanes follow the last row.
};

template <class Lanes, class T>
[[gnu::always_inline]] inline void Load(const T* from, Lanes* lanes) {
  std::memcpy(lanes, from, sizeof *lanes);
}

template <class Lanes, class T>
[[gnu::always_inline]] inline void Store(const Lanes& lanes, T* to) {
  std::memcpy(to, &lanes, sizeof lanes);
}

VANTAGE_SIMD void Fill(const Triangle& triangle, const Target& target) {
  // Slack of 1e-5 of the triangle keeps pixels on shared edges from falling between.
  constexpr float kSlack = -1e-5F;
  const F8 steps = {0, 1, 2, 3, 4, 5, 6, 7};
  const I8 mesh_id = I8{} + static_cast<int32_t>(triangle.mesh_id);
  const I8 triangle_id = I8{} + static_cast<int32_t>(triangle.id);
  const auto last_u = static_cast<float>(triangle.u1);
  size_t row = 0;
  for (int v = triangle.v0; v <= triangle.v1; ++v, row += target.stride) {
    const float dv = static_cast<float>(v) - triangle.v;
    const float b_row = dv * triangle.b_dv;
    const float c_row = dv * triangle.c_dv;
    size_t pixel = row;
    for (int u = triangle.u0; u <= triangle.u1; u += kLanes, pixel += kLanes) {
      const F8 us = static_cast<float>(u) + steps;
      const F8 du = us - triangle.u;
      const F8 weight_b = du * triangle.b_du + b_row;
      const F8 weight_c = du * triangle.c_du + c_row;
      const F8 weight_a = 1.0F - weight_b - weight_c;
      const F8 z =
          1.0F / (weight_a * triangle.a_w + weight_b * triangle.b_w + weight_c * triangle.c_w);
      F8 depth;
      I8 mesh_ids;
      I8 triangle_ids;
      Load(target.depth + pixel, &depth);
      Load(target.mesh_ids + pixel, &mesh_ids);
      Load(target.triangle_ids + pixel, &triangle_ids);
      const I8 wins = (weight_a >= kSlack) & (weight_b >= kSlack) & (weight_c >= kSlack) &
                      (z < depth) & (us <= last_u);
      Store(wins ? z : depth, target.depth + pixel);
      Store(wins ? mesh_id : mesh_ids, target.mesh_ids + pixel);
      Store(wins ? triangle_id : triangle_ids, target.triangle_ids + pixel);
    }
  }
}

}  // namespace

DepthRasterizer::DepthRasterizer(const CameraModel& camera) : camera_(camera) { Clear(); }

void DepthRasterizer::Clear(const PixelWindow& window) {
  const PixelWindow whole = WholeImage(camera_);
  VANTAGE_CHECK(!window.empty() && window.u0 >= 0 && window.v0 >= 0 && window.u1 <= whole.u1 &&
                    window.v1 <= whole.v1,
                "a window within the image");
  window_ = window;
  size_ = static_cast<size_t>(window.width()) * static_cast<size_t>(window.height());
  depth_.assign(size_ + kLanes, kEmpty);
  mesh_ids_.assign(size_ + kLanes, kNoId);
  triangle_ids_.assign(size_ + kLanes, kNoId);
}

DepthRasterizer::Corner DepthRasterizer::Project(const Eigen::Vector3f& p_camera) const {
  const float w = 1.0F / p_camera.z();
  return {static_cast<float>(camera_.fx) * p_camera.x() * w + static_cast<float>(camera_.cx),
          static_cast<float>(camera_.fy) * p_camera.y() * w + static_cast<float>(camera_.cy),
          w};
}

PixelWindow DepthRasterizer::Draw(const TriangleMesh& mesh,
                                  const Pose& T_camera_mesh,
                                  uint32_t mesh_id) {
  const Eigen::Matrix3f R = T_camera_mesh.linear().cast<float>();
  const Eigen::Vector3f t = T_camera_mesh.translation().cast<float>();
  p_camera_.resize(mesh.vertices.size());
  corners_.resize(mesh.vertices.size());
  for (size_t i = 0; i < mesh.vertices.size(); ++i) {
    p_camera_[i] = R * mesh.vertices[i] + t;
    corners_[i] = Project(p_camera_[i]);
  }
  PixelWindow touched{camera_.width, camera_.height, -1, -1};
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& [ia, ib, ic] = mesh.triangles[i];
    const auto id = static_cast<uint32_t>(i);
    if (p_camera_[ia].z() >= kNear && p_camera_[ib].z() >= kNear && p_camera_[ic].z() >= kNear) {
      DrawTriangle({corners_[ia], corners_[ib], corners_[ic]}, mesh_id, id, &touched);
      continue;
    }
    const std::array<Eigen::Vector3f, 3> corners = {p_camera_[ia], p_camera_[ib], p_camera_[ic]};
    // Clip at z = kNear: walk round the triangle and keep what is in front.
    std::array<Eigen::Vector3f, 4> polygon;
    size_t count = 0;
    for (size_t j = 0; j < 3; ++j) {
      const Eigen::Vector3f& from = corners[j];
      const Eigen::Vector3f& to = corners[(j + 1) % 3];
      if (from.z() >= kNear) polygon[count++] = from;
      if ((from.z() >= kNear) != (to.z() >= kNear)) {
        polygon[count] = from + (to - from) * ((kNear - from.z()) / (to.z() - from.z()));
        polygon[count++].z() = kNear;
      }
    }
    for (size_t j = 2; j < count; ++j) {
      DrawTriangle({Project(polygon[0]), Project(polygon[j - 1]), Project(polygon[j])},
                   mesh_id,
                   id,
                   &touched);
    }
  }
  return touched;
}

void DepthRasterizer::DrawTriangle(const std::array<Corner, 3>& corners,
                                   uint32_t mesh_id,
                                   uint32_t triangle_id,
                                   PixelWindow* touched) {
  const auto& [a, b, c] = corners;
  const float left = std::min({a.u, b.u, c.u});
  const float right = std::max({a.u, b.u, c.u});
  const float top = std::min({a.v, b.v, c.v});
  const float bottom = std::max({a.v, b.v, c.v});
  const auto first_u = static_cast<float>(window_.u0);
  const auto first_v = static_cast<float>(window_.v0);
  const auto last_u = static_cast<float>(window_.u1);
  const auto last_v = static_cast<float>(window_.v1);
  if (!(right >= first_u && left <= last_u && bottom >= first_v && top <= last_v)) {
    return;  // Outside, or not finite.
  }
  Triangle triangle{};
  triangle.u0 = static_cast<int>(std::ceil(std::max(left, first_u)));
  triangle.u1 = static_cast<int>(std::floor(std::min(right, last_u)));
  triangle.v0 = static_cast<int>(std::ceil(std::max(top, first_v)));
  triangle.v1 = static_cast<int>(std::floor(std::min(bottom, last_v)));

  const float area = (b.u - a.u) * (c.v - a.v) - (c.u - a.u) * (b.v - a.v);
  if (area == 0.0F || triangle.u0 > triangle.u1 || triangle.v0 > triangle.v1) return;
  const float inverse = 1.0F / area;
  triangle.u = a.u;
  triangle.v = a.v;
  triangle.b_du = (c.v - a.v) * inverse;
  triangle.b_dv = -(c.u - a.u) * inverse;
  triangle.c_du = -(b.v - a.v) * inverse;
  triangle.c_dv = (b.u - a.u) * inverse;
  triangle.a_w = a.w;
  triangle.b_w = b.w;
  triangle.c_w = c.w;
  triangle.mesh_id = mesh_id;
  triangle.id = triangle_id;
  touched->u0 = std::min(touched->u0, triangle.u0);
  touched->v0 = std::min(touched->v0, triangle.v0);
  touched->u1 = std::max(touched->u1, triangle.u1);
  touched->v1 = std::max(touched->v1, triangle.v1);
  const auto stride = static_cast<size_t>(window_.width());
  const size_t first = static_cast<size_t>(triangle.v0 - window_.v0) * stride +
                       static_cast<size_t>(triangle.u0 - window_.u0);
  Fill(triangle,
       {depth_.data() + first, mesh_ids_.data() + first, triangle_ids_.data() + first, stride});
}

}  // namespace vantage
