#include "perception/segmentation/normals.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "common/format.h"

namespace vantage {
namespace {

// Sums of the normal equations of rho = a du + b dv + c.
struct AffineFit {
  Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  int count = 0;

  void Add(int du, int dv, double rho) {
    const Eigen::Vector3d row(du, dv, 1.0);
    moments += row * row.transpose();
    right += rho * row;
    ++count;
  }
  [[nodiscard]] std::optional<Eigen::Vector3d> Solve() const {
    const double determinant = moments.determinant();
    if (!(determinant > 1e-6 * std::pow(static_cast<double>(count), 3.0))) return std::nullopt;
    return Eigen::Vector3d(moments.inverse() * right);
  }
};

}  // namespace

Result<void> NormalParameters::Validate() const {
  if (!(radius > 0.0 && radius < 1.0) || min_radius_px < 1 || max_radius_px < min_radius_px ||
      max_radius_px > 100 || !(min_share >= 0.0 && min_share <= 1.0)) {
    return Error{
        ErrorCode::kInvalidArgument,
        Format("normals: radius = %g m (expected 0 to 1), %d to %d px (expected 1 to 100), "
               "min_share = %g (expected 0 to 1)",
               radius,
               min_radius_px,
               max_radius_px,
               min_share)};
  }
  return {};
}

std::optional<SurfacePoint> SurfaceAt(const DepthImage& depth,
                                      const CameraModel& camera,
                                      std::span<const int32_t> labels,
                                      uint32_t pixel,
                                      const NormalParameters& parameters) {
  const int u = static_cast<int>(pixel) % depth.width;
  const int v = static_cast<int>(pixel) / depth.width;
  const auto z = static_cast<double>(depth.depth[pixel]);
  if (!(z > 0.0)) return std::nullopt;
  const int radius = std::clamp(static_cast<int>(std::lround(parameters.radius * camera.fx / z)),
                                parameters.min_radius_px,
                                parameters.max_radius_px);
  const double sigma = parameters.noise.Axial(z);
  const double gate = 2.0 * parameters.radius + 3.0 * sigma;
  const int32_t label = labels[pixel];
  const int full = (2 * radius + 1) * (2 * radius + 1);
  std::optional<Eigen::Vector3d> fit;
  for (int pass = 0; pass < 2; ++pass) {
    // The second pass keeps what agrees with the first: the near side of creases.
    const double tolerance = 2.5 * sigma / (z * z);
    AffineFit sums;
    for (int dv = -radius; dv <= radius; ++dv) {
      for (int du = -radius; du <= radius; ++du) {
        if (!depth.Contains(u + du, v + dv)) continue;
        const size_t neighbor = depth.Index(u + du, v + dv);
        if (labels[neighbor] != label) continue;
        const auto z_neighbor = static_cast<double>(depth.depth[neighbor]);
        if (!(std::abs(z_neighbor - z) <= gate)) continue;
        const double rho = 1.0 / z_neighbor;
        if (fit && std::abs(fit->x() * du + fit->y() * dv + fit->z() - rho) > tolerance) continue;
        sums.Add(du, dv, rho);
      }
    }
    if (sums.count < parameters.min_share * full) return std::nullopt;
    fit = sums.Solve();
    if (!fit || !(fit->z() > 0.0)) return std::nullopt;
  }
  // n . (x, y, 1) = k rho along a line of sight (x, y, 1).
  const double a = fit->x();
  const double b = fit->y();
  const Eigen::Vector3d away(
      a * camera.fx, b * camera.fy, fit->z() + a * (camera.cx - u) + b * (camera.cy - v));
  SurfacePoint point;
  point.position = camera.Unproject(u, v, 1.0 / fit->z()).cast<float>();
  point.normal = (-away.normalized()).cast<float>();
  return point;
}

std::vector<SurfacePoint> SampleSurfaces(const DepthImage& depth,
                                         const CameraModel& camera,
                                         std::span<const int32_t> labels,
                                         std::span<const uint32_t> pixels,
                                         double spacing,
                                         const NormalParameters& parameters) {
  struct Cube {
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    float count = 0.0F;
    float nearest = std::numeric_limits<float>::infinity();
    uint32_t pixel = 0;
  };
  std::vector<Cube> cubes;
  std::vector<uint32_t> cube_of(pixels.size());
  std::vector<Eigen::Vector3f> points(pixels.size());
  std::unordered_map<uint64_t, uint32_t> index_of;
  const auto inverse = static_cast<float>(1.0 / spacing);
  for (size_t i = 0; i < pixels.size(); ++i) {
    const int u = static_cast<int>(pixels[i]) % depth.width;
    const int v = static_cast<int>(pixels[i]) / depth.width;
    points[i] = camera.Unproject(u, v, static_cast<double>(depth.depth[pixels[i]])).cast<float>();
    uint64_t key = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const auto cell = static_cast<int64_t>(std::floor(points[i](axis) * inverse)) + (1 << 20);
      key = (key << 21U) | (static_cast<uint64_t>(cell) & 0x1fffffU);
    }
    const auto [place, is_new] = index_of.try_emplace(key, static_cast<uint32_t>(cubes.size()));
    if (is_new) cubes.emplace_back();
    cube_of[i] = place->second;
    cubes[place->second].sum += points[i];
    cubes[place->second].count += 1.0F;
  }
  for (size_t i = 0; i < pixels.size(); ++i) {
    Cube& cube = cubes[cube_of[i]];
    const float distance = (points[i] - cube.sum / cube.count).squaredNorm();
    if (distance < cube.nearest) {
      cube.nearest = distance;
      cube.pixel = pixels[i];
    }
  }
  std::vector<SurfacePoint> samples;
  samples.reserve(cubes.size());
  for (const Cube& cube : cubes) {
    if (auto point = SurfaceAt(depth, camera, labels, cube.pixel, parameters)) {
      samples.push_back(*point);
    }
  }
  return samples;
}

}  // namespace vantage
