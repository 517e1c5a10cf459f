#include "tools/support/sphere_renderer.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/so3.h"
#include "tools/support/rgb_canvas.h"

namespace vantage {
namespace {

constexpr int kMargin = 8;  // px
constexpr int kSupersampling = 2;
constexpr double kGrid = 30.0 * kDegree;

// One half of the sphere, orthographic.
struct Hemisphere {
  Eigen::Matrix3d R_view_world;  // z towards the viewer, x right, y up.
  Eigen::Vector2d center;        // px, of the fine picture
  double radius;                 // px
  int size;                      // px, of the square of densities
  std::vector<double> density;

  [[nodiscard]] Eigen::Vector2d Pixel(const Eigen::Vector3d& p_view) const {
    return {center.x() + radius * p_view.x(), center.y() - radius * p_view.y()};
  }
};

// The point of the unit sphere behind a pixel of the square; false outside the disk.
bool PointAt(int column, int row, double radius, Eigen::Vector3d* p_view) {
  const double x = (column - radius) / radius;
  const double y = (radius - row) / radius;
  const double rest = 1.0 - x * x - y * y;
  if (rest < 0.0) return false;
  *p_view = {x, y, std::sqrt(rest)};
  return true;
}

// Adds a sample's kernel (Gaussian of the angle, to 3 deviations) to the pixels that it reaches.
void Splat(const SphereSample& sample, double kernel, Hemisphere& half) {
  const Eigen::Vector3d at = half.R_view_world * sample.direction.cast<double>();
  const double reach = 3.0 * kernel;
  if (at.z() < -std::sin(std::min(reach, 1.5))) return;
  const double span = half.radius * 2.0 * std::sin(std::min(0.5 * reach, 1.5));
  const double column = half.radius * (1.0 + at.x());
  const double row = half.radius * (1.0 - at.y());
  const int first_row = std::max(0, static_cast<int>(row - span));
  const int last_row = std::min(half.size - 1, static_cast<int>(row + span) + 1);
  const int first_column = std::max(0, static_cast<int>(column - span));
  const int last_column = std::min(half.size - 1, static_cast<int>(column + span) + 1);
  for (int v = first_row; v <= last_row; ++v) {
    for (int u = first_column; u <= last_column; ++u) {
      Eigen::Vector3d point;
      if (!PointAt(u, v, half.radius, &point)) continue;
      const double chord2 = (point - at).squaredNorm();  // angle^2 to within 1 % for small kernels
      if (chord2 > reach * reach) continue;
      half.density[static_cast<size_t>(v) * static_cast<size_t>(half.size) +
                   static_cast<size_t>(u)] +=
          static_cast<double>(sample.weight) * std::exp(-0.5 * chord2 / (kernel * kernel));
    }
  }
}

// Share of a line of the graticule at a point, and the light that makes the ball look round.
Rgb SurfaceColor(const Hemisphere& half, const Eigen::Vector3d& p_view, double density) {
  const Eigen::Vector3d p_world = half.R_view_world.transpose() * p_view;
  const double latitude = std::asin(std::clamp(p_world.z(), -1.0, 1.0));
  const double longitude = std::atan2(p_world.y(), p_world.x());
  const double off_parallel = std::abs(std::remainder(latitude, kGrid));
  const double off_meridian =
      std::abs(std::remainder(longitude, kGrid)) * std::hypot(p_world.x(), p_world.y());
  const double width = 0.9 / half.radius / std::max(p_view.z(), 0.25);
  const bool line = std::min(off_parallel, off_meridian) < width;
  const double light = 0.80 + 0.20 * p_view.dot(Eigen::Vector3d(-0.35, 0.45, 0.82));
  Rgb color = DensityColor(density);
  if (line) color = Mix(color, {90, 98, 112}, 0.22);
  return Mix({40, 44, 52}, color, std::clamp(light, 0.0, 1.0));
}

void PaintHemisphere(const Hemisphere& half, double highest, RgbImage& image) {
  const auto left = static_cast<int>(std::lround(half.center.x() - half.radius));
  const auto top = static_cast<int>(std::lround(half.center.y() - half.radius));
  for (int v = 0; v < half.size; ++v) {
    for (int u = 0; u < half.size; ++u) {
      Eigen::Vector3d point;
      if (!PointAt(u, v, half.radius, &point)) continue;
      const double density = half.density[static_cast<size_t>(v) * static_cast<size_t>(half.size) +
                                          static_cast<size_t>(u)];
      SetPixel(image,
               left + u,
               top + v,
               SurfaceColor(half, point, highest > 0.0 ? density / highest : 0.0));
    }
  }
  static constexpr Rgb kAxisColors[3] = {{208, 46, 46}, {44, 150, 60}, {40, 84, 208}};
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {1.0, -1.0}) {
      const Eigen::Vector3d at = half.R_view_world * (sign * Eigen::Vector3d::Unit(axis));
      if (at.z() < -0.05) continue;
      DrawDisk(image, half.Pixel(at), 4.5 * kSupersampling, {255, 255, 255});
      DrawDisk(image, half.Pixel(at), 3.5 * kSupersampling, kAxisColors[axis]);
      if (sign < 0.0) DrawDisk(image, half.Pixel(at), 1.8 * kSupersampling, {255, 255, 255});
    }
  }
}

}  // namespace

Eigen::Matrix3d ViewRotation(const Eigen::Vector3d& towards) {
  const Eigen::Vector3d z = towards.normalized();
  Eigen::Vector3d x = Eigen::Vector3d::UnitZ().cross(z);
  if (x.norm() < 1e-6) x = Eigen::Vector3d::UnitX();
  x.normalize();
  Eigen::Matrix3d rotation;
  rotation.row(0) = x;
  rotation.row(1) = z.cross(x);
  rotation.row(2) = z;
  return rotation;
}

Eigen::Vector3d DirectionOfOrientation(const Eigen::Quaterniond& orientation) {
  return orientation * Eigen::Vector3d::Ones().normalized();
}

RgbImage RenderSphereDensity(std::span<const SphereSample> samples, const SphereView& view) {
  const double radius = view.radius_px * kSupersampling;
  const double margin = kMargin * kSupersampling;
  const int size = 2 * view.radius_px * kSupersampling + 1;
  const auto half_of = [&](const Eigen::Vector3d& towards, double center_x) {
    return Hemisphere{ViewRotation(towards),
                      {center_x, margin + radius},
                      radius,
                      size,
                      std::vector<double>(static_cast<size_t>(size) * static_cast<size_t>(size))};
  };
  Hemisphere halves[2] = {half_of(view.towards, margin + radius),
                          half_of(-view.towards, 2.0 * margin + 3.0 * radius)};
  double highest = 0.0;
  for (Hemisphere& half : halves) {
    for (const SphereSample& sample : samples) Splat(sample, view.kernel, half);
    highest = std::max(highest, *std::max_element(half.density.begin(), half.density.end()));
  }
  RgbImage image = FilledImage(kSupersampling * (4 * view.radius_px + 3 * kMargin),
                               kSupersampling * (2 * view.radius_px + 2 * kMargin),
                               view.background);
  for (const Hemisphere& half : halves) PaintHemisphere(half, highest, image);
  return Downsample(image, kSupersampling);
}

}  // namespace vantage
