#include "perception/segmentation/surface_sampler.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "common/simd.h"

namespace vantage {
namespace {

// A window of the image and the plane rho = a du + b dv + c about its middle, in which rho is
// relative to that of the middle.
struct Window {
  const float* rho;       // Of its middle.
  const int32_t* labels;  // Likewise.
  std::ptrdiff_t stride;
  int radius;
  float gate;       // 1/m, from the middle
  float tolerance;  // 1/m, from the plane
};

struct Plane {
  float a = 0.0F, b = 0.0F, c = 0.0F;
};

// n, u, v, uu, uv, vv, rho, u rho, v rho: sums over pixels.
struct Sums {
  float n, u, v, uu, uv, vv, r, ur, vr;
};

[[gnu::always_inline]] inline float Total(const F8& lanes) {
  return ((lanes[0] + lanes[4]) + (lanes[2] + lanes[6])) +
         ((lanes[1] + lanes[5]) + (lanes[3] + lanes[7]));
}

// Columns in lanes: sums over rows first.
VANTAGE_SIMD void SumWindow(const Window& window, const Plane& plane, Sums* sums) {
  const F8 lane = {0.0F, 1.0F, 2.0F, 3.0F, 4.0F, 5.0F, 6.0F, 7.0F};
  const F8 zero = lane - lane;
  const float middle = *window.rho;
  const int32_t label = *window.labels;
  const int radius = window.radius;
  F8 n = zero;
  F8 u = zero;
  F8 v = zero;
  F8 uu = zero;
  F8 uv = zero;
  F8 vv = zero;
  F8 r = zero;
  F8 ur = zero;
  F8 vr = zero;
  for (int first = -radius; first <= radius; first += kLanes) {
    const F8 du = lane + static_cast<float>(first);
    const I8 is_within = du <= static_cast<float>(radius);
    const F8 along = plane.a * du + plane.c;
    F8 count = zero;
    F8 count_v = zero;
    F8 count_vv = zero;
    F8 sum = zero;
    F8 sum_v = zero;
    for (int dv = -radius; dv <= radius; ++dv) {
      const std::ptrdiff_t offset = dv * window.stride + first;
      F8 rho;
      I8 labels;
      std::memcpy(&rho, window.rho + offset, sizeof(rho));
      std::memcpy(&labels, window.labels + offset, sizeof(labels));
      const auto row = static_cast<float>(dv);
      rho = rho - middle;
      const F8 error = along + plane.b * row - rho;
      // Comparisons with NaN, where nothing is measured, are false.
      const I8 is_used = is_within & (labels == label) & (rho <= window.gate) &
                         (rho >= -window.gate) & (error <= window.tolerance) &
                         (error >= -window.tolerance);
      const F8 one = is_used ? zero + 1.0F : zero;
      const F8 value = is_used ? rho : zero;
      count += one;
      count_v += one * row;
      count_vv += one * (row * row);
      sum += value;
      sum_v += value * row;
    }
    n += count;
    u += du * count;
    v += count_v;
    uu += du * du * count;
    uv += du * count_v;
    vv += count_vv;
    r += sum;
    ur += du * sum;
    vr += sum_v;
  }
  *sums = {Total(n),
           Total(u),
           Total(v),
           Total(uu),
           Total(uv),
           Total(vv),
           Total(r),
           Total(ur),
           Total(vr)};
}

// False when the pixels are on a line.
bool Solve(const Sums& sums, Plane* plane) {
  const float uu = sums.uu - sums.u * sums.u / sums.n;
  const float uv = sums.uv - sums.u * sums.v / sums.n;
  const float vv = sums.vv - sums.v * sums.v / sums.n;
  const float ur = sums.ur - sums.u * sums.r / sums.n;
  const float vr = sums.vr - sums.v * sums.r / sums.n;
  const float determinant = uu * vv - uv * uv;
  if (!(determinant > 1e-3F * sums.n * sums.n)) return false;
  plane->a = (ur * vv - vr * uv) / determinant;
  plane->b = (vr * uu - ur * uv) / determinant;
  plane->c = (sums.r - plane->a * sums.u - plane->b * sums.v) / sums.n;
  return true;
}

VANTAGE_SIMD void Invert(const float* depth, int size, float* rho) {
  for (int i = 0; i < size; ++i) rho[i] = 1.0F / depth[i];
}

}  // namespace

// With a margin that no fit leaves.
void SurfaceSampler::CopyWindow(const DepthImage& depth,
                                std::span<const int32_t> labels,
                                const PixelWindow& inner) {
  const int margin = parameters_.max_radius_px;
  window_ = {inner.u0 - margin, inner.v0 - margin, inner.u1 + margin, inner.v1 + margin};
  stride_ = static_cast<size_t>(window_.u1 - window_.u0 + 1 + kLanes);
  const size_t size = stride_ * static_cast<size_t>(window_.v1 - window_.v0 + 1);
  rho_.assign(size, std::numeric_limits<float>::quiet_NaN());
  labels_.assign(size, -1);
  const int u0 = std::max(window_.u0, 0);
  const int width = std::min(window_.u1, depth.width - 1) - u0 + 1;
  for (int v = std::max(window_.v0, 0); v <= std::min(window_.v1, depth.height - 1); ++v) {
    const size_t from = depth.Index(u0, v);
    const size_t to = Place(u0, v);
    Invert(depth.depth.data() + from, width, rho_.data() + to);
    std::copy_n(labels.data() + from, width, labels_.data() + to);
  }
}

// One of each cube; of many pixels in a cube some are enough to tell it.
void SurfaceSampler::ChoosePixels(const DepthImage& depth,
                                  const CameraModel& camera,
                                  const Cluster& cluster,
                                  double spacing) {
  constexpr double kPixelsAcross = 3.0;  // Of a cube.
  const auto nearest = static_cast<double>(depth.depth[cluster.pixels.front()]);
  const int step =
      std::clamp(static_cast<int>(spacing * camera.fx / (kPixelsAcross * nearest)), 1, 16);
  const Eigen::Vector2f inverse(static_cast<float>(1.0 / camera.fx),
                                static_cast<float>(1.0 / camera.fy));
  const Eigen::Vector2f origin(static_cast<float>(camera.cx), static_cast<float>(camera.cy));
  cubes_.Clear(cluster.pixels.size(), spacing);
  pixels_.clear();
  const auto width = static_cast<uint32_t>(depth.width);
  uint32_t row = 0;
  uint32_t row_end = 0;
  for (const uint32_t pixel : cluster.pixels) {
    if (pixel >= row_end) {
      row = pixel / width;
      row_end = (row + 1) * width;
    }
    const auto v = static_cast<int>(row);
    const auto u = static_cast<int>(pixel + width - row_end);
    if (step > 1 && ((v - window_.v0) % step != 0 || (u - window_.u0) % step != 0)) continue;
    const float z = depth.depth[pixel];
    cubes_.Add({(static_cast<float>(u) - origin.x()) * inverse.x() * z,
                (static_cast<float>(v) - origin.y()) * inverse.y() * z,
                z});
    pixels_.push_back(pixel);
  }
}

void SurfaceSampler::AddSurfaceAt(const CameraModel& camera, uint32_t pixel, int width) {
  const int u = static_cast<int>(pixel) % width;
  const int v = static_cast<int>(pixel) / width;
  const size_t place = Place(u, v);
  const auto rho = static_cast<double>(rho_[place]);
  const double z = 1.0 / rho;
  const int radius = std::clamp(static_cast<int>(std::lround(parameters_.radius * camera.fx / z)),
                                parameters_.min_radius_px,
                                parameters_.max_radius_px);
  const double sigma = parameters_.noise.Axial(z);
  const double gate = (2.0 * parameters_.radius + 3.0 * sigma) * rho * rho;
  const double fewest = parameters_.min_share * (2 * radius + 1) * (2 * radius + 1);
  Window window{rho_.data() + place,
                labels_.data() + place,
                static_cast<std::ptrdiff_t>(stride_),
                radius,
                static_cast<float>(gate),
                std::numeric_limits<float>::infinity()};
  Plane plane;
  for (int pass = 0; pass < 2; ++pass) {
    Sums sums{};
    SumWindow(window, plane, &sums);
    if (static_cast<double>(sums.n) < fewest || !Solve(sums, &plane)) return;
    // The second pass keeps what agrees with the first: the near side of creases.
    window.tolerance = static_cast<float>(2.5 * sigma * rho * rho);
  }
  const double c = rho + static_cast<double>(plane.c);
  if (!(c > 0.0)) return;
  // n . (x, y, 1) = k rho along a line of sight (x, y, 1).
  const auto a = static_cast<double>(plane.a);
  const auto b = static_cast<double>(plane.b);
  const Eigen::Vector3d away(
      a * camera.fx, b * camera.fy, c + a * (camera.cx - u) + b * (camera.cy - v));
  samples_.push_back(
      {camera.Unproject(u, v, 1.0 / c).cast<float>(), (-away.normalized()).cast<float>()});
}

std::span<const SurfacePoint> SurfaceSampler::Sample(const DepthImage& depth,
                                                     const CameraModel& camera,
                                                     std::span<const int32_t> labels,
                                                     const Cluster& cluster,
                                                     double spacing) {
  samples_.clear();
  if (cluster.pixels.empty()) return samples_;
  CopyWindow(depth, labels, cluster.window);
  ChoosePixels(depth, camera, cluster, spacing);
  for (const uint32_t chosen : cubes_.Choose()) {
    AddSurfaceAt(camera, pixels_[chosen], depth.width);
  }
  return samples_;
}

std::span<const SurfacePoint> SurfaceSampler::Thin(std::span<const SurfacePoint> points,
                                                   double spacing) {
  cubes_.Clear(points.size(), spacing);
  for (const SurfacePoint& point : points) cubes_.Add(point.position);
  thinned_.clear();
  for (const uint32_t chosen : cubes_.Choose()) thinned_.push_back(points[chosen]);
  return thinned_;
}

}  // namespace vantage
