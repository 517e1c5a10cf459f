#include "common/depth_rasterizer.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/check.h"

namespace vantage {

DepthRasterizer::DepthRasterizer(const CameraModel& camera) : camera_(camera) { Clear(); }

void DepthRasterizer::Clear(const PixelWindow& window) {
  const PixelWindow whole = WholeImage(camera_);
  VANTAGE_CHECK(!window.empty() && window.u0 >= 0 && window.v0 >= 0 && window.u1 <= whole.u1 &&
                    window.v1 <= whole.v1,
                "a window within the image");
  window_ = window;
  const size_t size = static_cast<size_t>(window.width()) * static_cast<size_t>(window.height());
  depth_.assign(size, kEmpty);
  mesh_ids_.assign(size, kNoId);
  triangle_ids_.assign(size, kNoId);
}

PixelWindow DepthRasterizer::Draw(const TriangleMesh& mesh,
                                  const Pose& T_camera_mesh,
                                  uint32_t mesh_id) {
  const Eigen::Matrix3f R = T_camera_mesh.linear().cast<float>();
  const Eigen::Vector3f t = T_camera_mesh.translation().cast<float>();
  p_camera_.resize(mesh.vertices.size());
  for (size_t i = 0; i < mesh.vertices.size(); ++i) {
    p_camera_[i] = R * mesh.vertices[i] + t;
  }
  PixelWindow touched{camera_.width, camera_.height, -1, -1};
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& [ia, ib, ic] = mesh.triangles[i];
    const std::array<Eigen::Vector3f, 3> corners = {p_camera_[ia], p_camera_[ib], p_camera_[ic]};
    const auto id = static_cast<uint32_t>(i);
    if (corners[0].z() >= kNear && corners[1].z() >= kNear && corners[2].z() >= kNear) {
      DrawTriangle(corners[0], corners[1], corners[2], mesh_id, id, &touched);
      continue;
    }
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
      DrawTriangle(polygon[0], polygon[j - 1], polygon[j], mesh_id, id, &touched);
    }
  }
  return touched;
}

void DepthRasterizer::DrawTriangle(const Eigen::Vector3f& a,
                                   const Eigen::Vector3f& b,
                                   const Eigen::Vector3f& c,
                                   uint32_t mesh_id,
                                   uint32_t triangle_id,
                                   PixelWindow* touched) {
  const auto fx = static_cast<float>(camera_.fx);
  const auto fy = static_cast<float>(camera_.fy);
  const auto cx = static_cast<float>(camera_.cx);
  const auto cy = static_cast<float>(camera_.cy);
  // 1 / z is affine in the image, so it is what gets interpolated.
  const float wa = 1.0F / a.z();
  const float wb = 1.0F / b.z();
  const float wc = 1.0F / c.z();
  const float ua = fx * a.x() * wa + cx;
  const float va = fy * a.y() * wa + cy;
  const float ub = fx * b.x() * wb + cx;
  const float vb = fy * b.y() * wb + cy;
  const float uc = fx * c.x() * wc + cx;
  const float vc = fy * c.y() * wc + cy;

  const float left = std::min({ua, ub, uc});
  const float right = std::max({ua, ub, uc});
  const float top = std::min({va, vb, vc});
  const float bottom = std::max({va, vb, vc});
  const auto first_u = static_cast<float>(window_.u0);
  const auto first_v = static_cast<float>(window_.v0);
  const auto last_u = static_cast<float>(window_.u1);
  const auto last_v = static_cast<float>(window_.v1);
  if (!(right >= first_u && left <= last_u && bottom >= first_v && top <= last_v)) {
    return;  // Outside, or not finite.
  }
  const int u0 = static_cast<int>(std::ceil(std::max(left, first_u)));
  const int u1 = static_cast<int>(std::floor(std::min(right, last_u)));
  const int v0 = static_cast<int>(std::ceil(std::max(top, first_v)));
  const int v1 = static_cast<int>(std::floor(std::min(bottom, last_v)));

  const float area = (ub - ua) * (vc - va) - (uc - ua) * (vb - va);
  if (area == 0.0F || u0 > u1 || v0 > v1) return;
  const float inverse = 1.0F / area;
  // Barycentric weights of b and c are affine in (u, v).
  const float b_du = (vc - va) * inverse;
  const float b_dv = -(uc - ua) * inverse;
  const float c_du = -(vb - va) * inverse;
  const float c_dv = (ub - ua) * inverse;
  // Slack of 1e-5 of the triangle keeps pixels on shared edges from falling between.
  constexpr float kSlack = -1e-5F;
  touched->u0 = std::min(touched->u0, u0);
  touched->v0 = std::min(touched->v0, v0);
  touched->u1 = std::max(touched->u1, u1);
  touched->v1 = std::max(touched->v1, v1);
  for (int v = v0; v <= v1; ++v) {
    const float dv = static_cast<float>(v) - va;
    const size_t row = static_cast<size_t>(v - window_.v0) * static_cast<size_t>(window_.width());
    for (int u = u0; u <= u1; ++u) {
      const float du = static_cast<float>(u) - ua;
      const float weight_b = du * b_du + dv * b_dv;
      const float weight_c = du * c_du + dv * c_dv;
      const float weight_a = 1.0F - weight_b - weight_c;
      if (weight_a < kSlack || weight_b < kSlack || weight_c < kSlack) continue;
      const float z = 1.0F / (weight_a * wa + weight_b * wb + weight_c * wc);
      const size_t pixel = row + static_cast<size_t>(u - window_.u0);
      if (z < depth_[pixel]) {
        depth_[pixel] = z;
        mesh_ids_[pixel] = mesh_id;
        triangle_ids_[pixel] = triangle_id;
      }
    }
  }
}

}  // namespace vantage
