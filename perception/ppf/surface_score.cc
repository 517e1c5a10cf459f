#include "perception/ppf/surface_score.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "common/simd.h"
#include "common/so3.h"

namespace vantage {
namespace {

// The sphere falls into 24 sectors: which axis is the longest, and the three signs.
uint32_t Sector(const Eigen::Vector3f& direction) {
  Eigen::Index axis = 0;
  direction.cwiseAbs().maxCoeff(&axis);
  return static_cast<uint32_t>(axis) * 8U + (direction.x() < 0.0F ? 1U : 0U) +
         (direction.y() < 0.0F ? 2U : 0U) + (direction.z() < 0.0F ? 4U : 0U);
}

// The sectors within about 30 deg of a direction.
uint32_t SectorsAbout(const Eigen::Vector3f& direction) {
  uint32_t sectors = 1U << Sector(direction);
  const Eigen::Vector3f u = direction.unitOrthogonal();
  const Eigen::Vector3f v = direction.cross(u);
  for (const float tilt : {0.27F, 0.58F}) {
    for (int i = 0; i < 12; ++i) {
      const float around = 0.5236F * static_cast<float>(i);
      sectors |= 1U << Sector(direction + tilt * (std::cos(around) * u + std::sin(around) * v));
    }
  }
  return sectors;
}

[[gnu::always_inline]] inline void Load(const float* from, F8* to) {
  std::memcpy(to, from, sizeof(F8));
}

}  // namespace

SurfaceScore::SurfaceScore(std::span<const SurfacePoint> points,
                           double spacing,
                           double reach,
                           double cell)
    : cell_(static_cast<float>(cell)) {
  Eigen::AlignedBox3f box;
  for (const SurfacePoint& point : points) box.extend(point.position);
  // A cube wide border stays empty, where places outside are moved to.
  const auto margin = static_cast<float>(reach + 1.5 * cell);
  origin_ = box.min().array() - margin;
  size_ = ((box.max().array() + margin - origin_.array()) / cell_).ceil().cast<int>() + 1;
  cells_.assign(static_cast<size_t>(size_.x()) * static_cast<size_t>(size_.y()) *
                    static_cast<size_t>(size_.z()),
                0);
  for (const SurfacePoint& point : points) Stamp(point, spacing, reach);
}

// A point stands for a disc that overlaps with its neighbors'.
void SurfaceScore::Stamp(const SurfacePoint& point, double spacing, double reach) {
  const uint32_t sectors = SectorsAbout(point.normal) << 8U;
  const float disc = static_cast<float>(0.7 * spacing);
  const auto limit = static_cast<float>(reach);
  const auto extent = static_cast<int>(std::ceil((limit + disc) / cell_));
  const Eigen::Array3i middle = ((point.position - origin_).array() / cell_).floor().cast<int>();
  const Eigen::Array3i first = (middle - extent).max(1);
  const Eigen::Array3i last = (middle + extent).min(size_ - 2);
  for (int z = first.z(); z <= last.z(); ++z) {
    for (int y = first.y(); y <= last.y(); ++y) {
      for (int x = first.x(); x <= last.x(); ++x) {
        const Eigen::Vector3f place = origin_ + cell_ * (Eigen::Vector3f(static_cast<float>(x),
                                                                         static_cast<float>(y),
                                                                         static_cast<float>(z)) +
                                                         Eigen::Vector3f::Constant(0.5F));
        const Eigen::Vector3f d = place - point.position;
        const float height = d.dot(point.normal);
        const float beyond =
            std::max(0.0F, std::sqrt(std::max(0.0F, d.squaredNorm() - height * height)) - disc);
        const float share = (height * height + beyond * beyond) / (limit * limit);
        if (share >= 1.0F) continue;
        uint32_t& cell = cells_[static_cast<size_t>((z * size_.y() + y) * size_.x() + x)];
        const auto nearness = static_cast<uint32_t>(255.0F * (1.0F - share));
        cell = ((cell | sectors) & ~0xffU) | std::max(cell & 0xffU, nearness);
      }
    }
  }
}

VANTAGE_SIMD
float SurfaceScore::Score(const Eigen::Isometry3f& T_object_camera,
                          const SurfaceLanes& points) const {
  const Eigen::Matrix3f R = T_object_camera.linear();
  const Eigen::Matrix3f S = R / cell_;
  const Eigen::Vector3f t = (T_object_camera.translation() - origin_) / cell_;
  const float top_x = static_cast<float>(size_.x() - 1);
  const float top_y = static_cast<float>(size_.y() - 1);
  const float top_z = static_cast<float>(size_.z() - 1);
  const int row = size_.x();
  const int plane = size_.x() * size_.y();
  I8 sum = {};
  const F8 zero = {};
  const size_t whole = points.x.size() / kLanes * kLanes;
  for (size_t i = 0; i < whole; i += kLanes) {
    F8 x, y, z;
    Load(&points.x[i], &x);
    Load(&points.y[i], &y);
    Load(&points.z[i], &z);
    F8 px = S(0, 0) * x + S(0, 1) * y + S(0, 2) * z + t.x();
    F8 py = S(1, 0) * x + S(1, 1) * y + S(1, 2) * z + t.y();
    F8 pz = S(2, 0) * x + S(2, 1) * y + S(2, 2) * z + t.z();
    // Comparisons fail on NaN, which so goes to the border.
    px = px > 0.0F ? (px < top_x ? px : zero) : zero;
    py = py > 0.0F ? (py < top_y ? py : zero) : zero;
    pz = pz > 0.0F ? (pz < top_z ? pz : zero) : zero;
    const I8 index = __builtin_convertvector(pz, I8) * plane +
                     __builtin_convertvector(py, I8) * row + __builtin_convertvector(px, I8);
    I8 cell;
    for (int k = 0; k < kLanes; ++k) {
      cell[k] = static_cast<int32_t>(cells_[static_cast<size_t>(index[k])]);
    }
    Load(&points.normal_x[i], &x);
    Load(&points.normal_y[i], &y);
    Load(&points.normal_z[i], &z);
    const F8 nx = R(0, 0) * x + R(0, 1) * y + R(0, 2) * z;
    const F8 ny = R(1, 0) * x + R(1, 1) * y + R(1, 2) * z;
    const F8 nz = R(2, 0) * x + R(2, 1) * y + R(2, 2) * z;
    const F8 ax = nx < 0.0F ? -nx : nx;
    const F8 ay = ny < 0.0F ? -ny : ny;
    const F8 az = nz < 0.0F ? -nz : nz;
    // Comparisons give 0 or -1.
    const I8 is_x = (ax >= ay) & (ax >= az);
    const I8 is_y = ~is_x & (ay >= az);
    I8 sector = 16 + (is_y & -8) + (is_x & -16);
    sector += ((nx < 0.0F) & 1) + ((ny < 0.0F) & 2) + ((nz < 0.0F) & 4);
    const I8 agrees = (cell >> (sector + 8)) & 1;
    sum += (cell & 0xff) & -agrees;
  }
  int total = 0;
  for (int k = 0; k < kLanes; ++k) total += sum[k];
  return static_cast<float>(total) / 255.0F;
}

}  // namespace vantage
