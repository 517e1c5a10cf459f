#include "perception/segmentation/foreground.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "common/simd.h"

namespace vantage {
namespace {

struct RowHeights {
  float along_u;   // Of the height over z.
  float constant;  // Likewise.
  float offset;    // m
};

struct Limits {
  float low, high;                          // m
  float noise_base, noise_quadratic, knee;  // Of the noise along z times its sigmas.
};

// How far from the plane a pixel must be, m, for its noise along the plane's normal.
[[gnu::always_inline]] inline float Clearance(float z, float slope, const Limits& limits) {
  const float beyond = std::max(z - limits.knee, 0.0F);
  const float noise = limits.noise_base + limits.noise_quadratic * beyond * beyond;
  return std::max(limits.low, noise * std::abs(slope));
}

VANTAGE_SIMD void MarkUsable(
    const float* depth, int width, float nearest, float farthest, uint8_t* mask) {
  for (int u = 0; u < width; ++u) {
    const float z = depth[u];
    mask[u] =
        static_cast<uint8_t>(static_cast<int>(z >= nearest) & static_cast<int>(z <= farthest));
  }
}

VANTAGE_SIMD void MarkAbove(const float* depth,
                            const float* columns,
                            int width,
                            const RowHeights& row,
                            const Limits& limits,
                            uint8_t* mask) {
  for (int u = 0; u < width; ++u) {
    const float z = depth[u];
    const float slope = row.along_u * columns[u] + row.constant;
    const float height = z * slope - row.offset;
    mask[u] = static_cast<uint8_t>(static_cast<int>(height > Clearance(z, slope, limits)) &
                                   static_cast<int>(height <= limits.high));
  }
}

VANTAGE_SIMD void MarkOn(const float* depth,
                         const float* columns,
                         int width,
                         const RowHeights& row,
                         const Limits& limits,
                         uint8_t* mask) {
  for (int u = 0; u < width; ++u) {
    const float z = depth[u];
    const float slope = row.along_u * columns[u] + row.constant;
    const float height = z * slope - row.offset;
    mask[u] = std::abs(height) <= Clearance(z, slope, limits) ? 1 : 0;
  }
}

VANTAGE_SIMD void And(const uint8_t* other, int width, uint8_t* mask) {
  for (int u = 0; u < width; ++u) mask[u] = mask[u] & other[u];
}

VANTAGE_SIMD void Or(const uint8_t* other, int width, uint8_t* mask) {
  for (int u = 0; u < width; ++u) mask[u] = mask[u] | other[u];
}

VANTAGE_SIMD void Subtract(const uint8_t* other, int width, uint8_t* mask) {
  for (int u = 0; u < width; ++u) mask[u] = mask[u] & static_cast<uint8_t>(other[u] ^ 1U);
}

bool IsEmpty(const uint8_t* mask, int width) {
  return std::memchr(mask, 1, static_cast<size_t>(width)) == nullptr;
}

}  // namespace

void Foreground::Prepare(const CameraModel& camera, std::span<const SupportPlane> planes) {
  const auto over_depth = [&](const Eigen::Vector3d& direction, double bound) {
    return HalfSpace{direction.x() / camera.fx,
                     direction.y() / camera.fy,
                     direction.z() - direction.x() * camera.cx / camera.fx -
                         direction.y() * camera.cy / camera.fy,
                     bound};
  };
  bodies_.clear();
  sides_.clear();
  for (const SupportPlane& plane : planes) {
    bodies_.push_back(
        {over_depth(plane.normal, plane.offset), sides_.size(), plane.hull.size(), plane.carries});
    for (size_t i = 0; i < plane.hull.size(); ++i) {
      const Eigen::Vector2d& corner = plane.hull[i];
      const Eigen::Vector2d side = (plane.hull[(i + 1) % plane.hull.size()] - corner).normalized();
      const Eigen::Vector2d inward(-side.y(), side.x());
      sides_.push_back(over_depth(inward.x() * plane.axis_x + inward.y() * plane.axis_y,
                                  inward.dot(corner) - parameters_.hull_margin));
    }
  }
  columns_.resize(static_cast<size_t>(camera.width));
  for (size_t u = 0; u < columns_.size(); ++u) columns_[u] = static_cast<float>(u);
  row_.resize(columns_.size());
}

// In eights, of which most hold no pixel that is asked for.
void Foreground::KeepOverHull(const Body& body, const float* depth, int v, uint8_t* mask) const {
  const int width = static_cast<int>(row_.size());
  if (IsEmpty(mask, width)) return;
  for (int begin = 0; begin < width; begin += kLanes) {
    const int end = std::min(begin + kLanes, width);
    uint64_t eight = 0;
    std::memcpy(&eight, mask + begin, static_cast<size_t>(end - begin));
    if (eight == 0) continue;
    for (size_t i = body.first_side; i < body.first_side + body.num_sides; ++i) {
      const HalfSpace& side = sides_[i];
      const auto along = static_cast<float>(side.along_u);
      const auto constant = static_cast<float>(side.along_v * v + side.constant);
      const auto bound = static_cast<float>(side.bound);
      for (int u = begin; u < end; ++u) {
        const float inside = depth[u] * (along * columns_[static_cast<size_t>(u)] + constant);
        mask[u] = mask[u] & static_cast<uint8_t>(inside >= bound);
      }
    }
  }
}

void Foreground::FindRow(const float* depth, int v, uint8_t* mask) {
  constexpr double kSigmas = 3.0;
  const int width = static_cast<int>(row_.size());
  const DepthNoise& noise = parameters_.noise;
  const Limits limits{static_cast<float>(parameters_.min_height),
                      static_cast<float>(parameters_.max_height),
                      static_cast<float>(kSigmas * noise.axial_base),
                      static_cast<float>(kSigmas * noise.axial_quadratic),
                      static_cast<float>(noise.axial_offset)};
  const auto row_of = [v](const Body& body) {
    return RowHeights{static_cast<float>(body.height.along_u),
                      static_cast<float>(body.height.along_v * v + body.height.constant),
                      static_cast<float>(body.height.bound)};
  };
  if (!bodies_.empty()) std::fill(mask, mask + width, uint8_t{0});
  for (const Body& body : bodies_) {
    if (!body.carries) continue;
    MarkAbove(depth, columns_.data(), width, row_of(body), limits, row_.data());
    KeepOverHull(body, depth, v, row_.data());
    Or(row_.data(), width, mask);
  }
  // What is on the only plane isn't above any.
  for (const Body& body : bodies_) {
    if (bodies_.size() == 1 || IsEmpty(mask, width)) break;
    MarkOn(depth, columns_.data(), width, row_of(body), limits, row_.data());
    And(mask, width, row_.data());
    KeepOverHull(body, depth, v, row_.data());
    Subtract(row_.data(), width, mask);
  }
  const auto nearest = static_cast<float>(parameters_.min_depth);
  const auto farthest = static_cast<float>(parameters_.max_depth);
  if (bodies_.empty()) {
    MarkUsable(depth, width, nearest, farthest, mask);
  } else if (!IsEmpty(mask, width)) {
    MarkUsable(depth, width, nearest, farthest, row_.data());
    And(row_.data(), width, mask);
  }
}

std::span<const uint8_t> Foreground::Find(const DepthImage& depth,
                                          const CameraModel& camera,
                                          std::span<const SupportPlane> planes) {
  Prepare(camera, planes);
  mask_.resize(depth.depth.size());
  for (int v = 0; v < depth.height; ++v) {
    FindRow(depth.depth.data() + depth.Index(0, v), v, mask_.data() + depth.Index(0, v));
  }
  return mask_;
}

}  // namespace vantage
