#include "drivers/camera/ray_projection.h"

#include <cstring>
#include <optional>

#include "common/simd.h"

namespace vantage {
namespace {

constexpr double kMillimetres = 1e3;  // In a metre.
// Third coordinate of a ray that there is none of: it takes every depth behind the camera, from
// wherever that is.
constexpr float kNoRay = -1e9F;

struct Ray {
  const float* u;
  const float* v;
  const float* w;
};

struct Place {
  float* u;
  float* v;
  float* z;
};

// `depth_mm` may have any address, as all the rest.
VANTAGE_SIMD void Project(
    const uint16_t* depth_mm, int width, const Ray& ray, const float* offset, const Place& place) {
  using Depths = uint16_t __attribute__((vector_size(2 * kLanes)));
  for (int i = 0; i < width; i += kLanes) {
    Depths depths = {};
    if (i + kLanes <= width) {
      std::memcpy(&depths, depth_mm + i, sizeof(depths));
    } else {
      std::memcpy(&depths, depth_mm + i, static_cast<size_t>(2 * (width - i)));
    }
    F8 ray_u;
    F8 ray_v;
    F8 ray_w;
    std::memcpy(&ray_u, ray.u + i, sizeof(F8));
    std::memcpy(&ray_v, ray.v + i, sizeof(F8));
    std::memcpy(&ray_w, ray.w + i, sizeof(F8));
    const F8 depth = __builtin_convertvector(__builtin_convertvector(depths, I8), F8);
    const F8 w = depth * ray_w + offset[2];
    const I8 is_seen = (depth > 0.0F) & (w > RayProjection::kNear);
    const F8 inverse = 1.0F / (is_seen ? w : F8{} + 1.0F);
    const F8 u = (depth * ray_u + offset[0]) * inverse;
    const F8 v = (depth * ray_v + offset[1]) * inverse;
    const F8 z = is_seen ? w : F8{} + RayProjection::kFar;
    std::memcpy(place.u + i, &u, sizeof(F8));
    std::memcpy(place.v + i, &v, sizeof(F8));
    std::memcpy(place.z + i, &z, sizeof(F8));
  }
}

}  // namespace

RayProjection::RayProjection(const CameraIntrinsics& depth,
                             const CameraModel& target,
                             const Pose& T_target_depth)
    : width_(depth.camera.width),
      height_(depth.camera.height),
      stride_(static_cast<size_t>((width_ + kLanes - 1) / kLanes * kLanes)) {
  Eigen::Matrix3d K;
  K << target.fx, 0.0, target.cx, 0.0, target.fy, target.cy, 0.0, 0.0, 1.0;
  offset_ = (kMillimetres * K * T_target_depth.translation()).cast<float>();
  const Eigen::Matrix3d KR = K * T_target_depth.linear();
  const CameraModel& camera = depth.camera;
  const size_t size = stride_ * static_cast<size_t>(height_);
  u_.resize(size, 0.0F);
  v_.resize(size, 0.0F);
  w_.resize(size, kNoRay);
  for (int v = 0; v < height_; ++v) {
    for (int u = 0; u < width_; ++u) {
      const std::optional<Eigen::Vector2d> ideal =
          depth.distortion.Undistort({(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy});
      if (!ideal) continue;
      const Eigen::Vector3f ray = (KR * ideal->homogeneous()).cast<float>();
      const size_t i = static_cast<size_t>(v) * stride_ + static_cast<size_t>(u);
      u_[i] = ray.x();
      v_[i] = ray.y();
      w_[i] = ray.z();
    }
  }
}

void RayProjection::ProjectRow(
    int row, const uint16_t* depth_mm, float* u, float* v, float* z) const {
  const size_t first = static_cast<size_t>(row) * stride_;
  Project(depth_mm, width_, {&u_[first], &v_[first], &w_[first]}, offset_.data(), {u, v, z});
}

}  // namespace vantage
