#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <optional>
#include <set>

#include "perception/segmentation/surface_sampler.h"
#include "tests/perception/test_scenes.h"

namespace vantage {
namespace {

const CameraModel kCamera = [] {
  CameraModel camera;
  camera.width = 200;
  camera.height = 160;
  camera.cx = 99.5;
  camera.cy = 79.5;
  return camera;
}();

// Depth of the plane normal . p = offset.
DepthImage PlaneDepth(const Eigen::Vector3d& normal, double offset) {
  DepthImage depth(kCamera.width, kCamera.height);
  for (int v = 0; v < depth.height; ++v) {
    for (int u = 0; u < depth.width; ++u) {
      depth.at(u, v) = static_cast<float>(offset / normal.dot(kCamera.Unproject(u, v, 1.0)));
    }
  }
  return depth;
}

double Degrees(const Eigen::Vector3f& a, const Eigen::Vector3d& b) {
  return std::acos(std::clamp(a.cast<double>().dot(b), -1.0, 1.0)) / kDegree;
}

// The surface at one pixel.
std::optional<SurfacePoint> SurfaceAt(const DepthImage& depth,
                                      const CameraModel& camera,
                                      std::span<const int32_t> labels,
                                      uint32_t pixel,
                                      const NormalParameters& parameters) {
  const std::vector<SurfacePoint> samples =
      SampleSurfaces(depth, camera, labels, std::span(&pixel, 1), 0.01, parameters);
  if (samples.empty()) return std::nullopt;
  return samples.front();
}

// The same by definition, in double precision.
std::optional<Eigen::Vector3d> NormalByDefinition(const DepthImage& depth,
                                                  std::span<const int32_t> labels,
                                                  uint32_t pixel,
                                                  const NormalParameters& parameters) {
  const int u = static_cast<int>(pixel) % depth.width;
  const int v = static_cast<int>(pixel) / depth.width;
  const double z = static_cast<double>(depth.depth[pixel]);
  const int radius = std::clamp(static_cast<int>(std::lround(parameters.radius * kCamera.fx / z)),
                                parameters.min_radius_px,
                                parameters.max_radius_px);
  const double sigma = parameters.noise.Axial(z);
  Eigen::Vector3d fit(0.0, 0.0, 1.0 / z);
  for (const double tolerance :
       {(2.0 * parameters.radius + 3.0 * sigma) / (z * z), 2.5 * sigma / (z * z)}) {
    Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (int dv = -radius; dv <= radius; ++dv) {
      for (int du = -radius; du <= radius; ++du) {
        if (!depth.Contains(u + du, v + dv)) continue;
        const size_t at = depth.Index(u + du, v + dv);
        const double rho = 1.0 / static_cast<double>(depth.depth[at]);
        const Eigen::Vector3d row(du, dv, 1.0);
        const double gate = (2.0 * parameters.radius + 3.0 * sigma) / (z * z);
        if (labels[at] != labels[pixel] || !(std::abs(rho - 1.0 / z) <= gate)) continue;
        if (!(std::abs(fit.dot(row) - rho) <= tolerance)) continue;
        moments += row * row.transpose();
        right += rho * row;
      }
    }
    if (moments(2, 2) < parameters.min_share * (2 * radius + 1) * (2 * radius + 1)) {
      return std::nullopt;
    }
    fit = moments.inverse() * right;
  }
  const double k = fit.x() * (kCamera.cx - u) + fit.y() * (kCamera.cy - v);
  return -Eigen::Vector3d(fit.x() * kCamera.fx, fit.y() * kCamera.fy, fit.z() + k).normalized();
}

TEST(SurfaceSampler, AgreesWithDefinition) {
  Rng rng(2);
  DepthImage depth(kCamera.width, kCamera.height);
  std::vector<int32_t> labels(depth.depth.size(), 0);
  for (int v = 0; v < depth.height; ++v) {
    for (int u = 0; u < depth.width; ++u) {
      depth.at(u, v) =
          0.7F + 0.002F * static_cast<float>(std::abs(u % 60 - 30)) + (v % 50 == 0 ? 0.1F : 0.0F);
      if (rng.Below(20) == 0) depth.at(u, v) = DepthImage::kInvalid;
      labels[depth.Index(u, v)] = v / 70;
    }
  }
  AddNoise(kCamera.fx, 0.001, 0.0, rng, &depth);
  int compared = 0;
  for (uint32_t pixel = 0; pixel < depth.depth.size(); pixel += 53) {
    if (!(depth.depth[pixel] > 0.0F)) continue;
    const auto point = SurfaceAt(depth, kCamera, labels, pixel, {});
    const auto normal = NormalByDefinition(depth, labels, pixel, {});
    ASSERT_EQ(point.has_value(), normal.has_value()) << pixel;
    if (!point) continue;
    ++compared;
    // A pixel at the tolerance may fall to either side in another precision.
    EXPECT_LT(Degrees(point->normal, *normal), 1.5) << pixel;
  }
  EXPECT_GT(compared, 400);
}

TEST(SurfaceSampler, ThinsEvenlyAndAlwaysAlike) {
  const DepthImage depth = PlaneDepth(Eigen::Vector3d(0.2, -0.5, -1).normalized(), -0.6);
  const std::vector<int32_t> labels(depth.depth.size(), 0);
  std::vector<uint32_t> pixels(depth.depth.size());
  for (uint32_t i = 0; i < pixels.size(); ++i) pixels[i] = i;
  const auto points = SampleSurfaces(depth, kCamera, labels, pixels, 0.004, {});
  SurfaceSampler sampler({});
  const double spacing = 0.01;
  const auto span = sampler.Thin(points, spacing);
  const std::vector<SurfacePoint> thinned(span.begin(), span.end());
  EXPECT_LT(thinned.size(), points.size() / 3);
  std::set<std::array<int, 3>> cubes;
  const auto cube = [&](const SurfacePoint& point) {
    std::array<int, 3> cell{};
    for (int axis = 0; axis < 3; ++axis) {
      cell[static_cast<size_t>(axis)] =
          static_cast<int>(std::floor(point.position(axis) * static_cast<float>(1.0 / spacing)));
    }
    return cell;
  };
  for (const SurfacePoint& point : thinned) EXPECT_TRUE(cubes.insert(cube(point)).second);
  for (const SurfacePoint& point : points) EXPECT_TRUE(cubes.contains(cube(point)));
  const auto again = sampler.Thin(points, spacing);
  ASSERT_EQ(again.size(), thinned.size());
  for (size_t i = 0; i < again.size(); ++i) EXPECT_EQ(again[i].position, thinned[i].position);
}

TEST(SurfaceSampler, HasNothingOfNothing) {
  SurfaceSampler sampler({});
  EXPECT_TRUE(
      sampler.Sample(DepthImage(4, 4), kCamera, std::vector<int32_t>(16), {}, 0.01).empty());
  EXPECT_TRUE(sampler.Thin({}, 0.01).empty());
}

TEST(SurfaceSampler, IsExactOnPlanes) {
  for (const Eigen::Vector3d& direction :
       {Eigen::Vector3d(0, 0, -1), Eigen::Vector3d(0.5, -0.3, -1), Eigen::Vector3d(-1, 1, -1)}) {
    const Eigen::Vector3d normal = direction.normalized();
    const DepthImage depth = PlaneDepth(normal, 0.75 * normal.z());
    const std::vector<int32_t> labels(depth.depth.size(), 0);
    for (const auto& [u, v] : {std::pair{100, 80}, {3, 2}, {199, 159}}) {
      const auto pixel = static_cast<uint32_t>(depth.Index(u, v));
      const auto point = SurfaceAt(depth, kCamera, labels, pixel, {});
      ASSERT_TRUE(point.has_value());
      EXPECT_LT(Degrees(point->normal, normal), 0.1);
      EXPECT_NEAR(
          static_cast<double>(point->position.z()), static_cast<double>(depth.at(u, v)), 1e-5);
    }
  }
}

TEST(SurfaceSampler, SurvivesDisparitySteps) {
  const Eigen::Vector3d normal = Eigen::Vector3d(0.4, -0.5, -1).normalized();
  DepthImage depth = PlaneDepth(normal, 0.75 * normal.z());
  Rng rng(1);
  AddNoise(kCamera.fx, 0.0014, 0.125, rng, &depth);
  const std::vector<int32_t> labels(depth.depth.size(), 0);
  std::vector<double> errors;
  for (uint32_t pixel = 2000; pixel < 30000; pixel += 37) {
    const auto point = SurfaceAt(depth, kCamera, labels, pixel, {});
    ASSERT_TRUE(point.has_value());
    errors.push_back(Degrees(point->normal, normal));
  }
  std::sort(errors.begin(), errors.end());
  EXPECT_LT(errors[errors.size() / 2], 3.0);
  EXPECT_LT(errors[errors.size() * 95 / 100], 8.0);
}

TEST(SurfaceSampler, DoesNotMixSurfacesAcrossDiscontinuitiesAndLabels) {
  DepthImage depth(kCamera.width, kCamera.height, 0.7F);
  std::vector<int32_t> labels(depth.depth.size(), 0);
  for (int v = 0; v < depth.height; ++v) {
    for (int u = 100; u < depth.width; ++u) depth.at(u, v) = 0.9F;
    for (int u = 0; u < 50; ++u) {
      depth.at(u, v) = 0.705F;  // Within the gate, but of another cluster.
      labels[depth.Index(u, v)] = 1;
    }
  }
  for (const int u : {50, 51, 99, 100}) {
    const auto point =
        SurfaceAt(depth, kCamera, labels, static_cast<uint32_t>(depth.Index(u, 80)), {});
    ASSERT_TRUE(point.has_value());
    EXPECT_LT(Degrees(point->normal, {0, 0, -1}), 0.01) << u;
  }
}

TEST(SurfaceSampler, NeedsNeighbors) {
  DepthImage depth(kCamera.width, kCamera.height);
  const std::vector<int32_t> labels(depth.depth.size(), 0);
  const auto pixel = static_cast<uint32_t>(depth.Index(50, 50));
  EXPECT_FALSE(SurfaceAt(depth, kCamera, labels, pixel, {}).has_value());
  depth.depth[pixel] = 0.7F;
  EXPECT_FALSE(SurfaceAt(depth, kCamera, labels, pixel, {}).has_value());
  for (int u = 0; u < depth.width; ++u) depth.at(u, 50) = 0.7F;  // One row has no slope across.
  NormalParameters parameters;
  parameters.min_share = 0.0;
  EXPECT_FALSE(SurfaceAt(depth, kCamera, labels, pixel, parameters).has_value());
}

TEST(SurfaceSampler, KeepsSpacingAndCoversAll) {
  const Eigen::Vector3d normal = Eigen::Vector3d(0.2, -0.5, -1).normalized();
  const DepthImage depth = PlaneDepth(normal, 0.75 * normal.z());
  const std::vector<int32_t> labels(depth.depth.size(), 0);
  std::vector<uint32_t> pixels(depth.depth.size());
  for (uint32_t i = 0; i < pixels.size(); ++i) pixels[i] = i;
  const double spacing = 0.01;
  const auto samples = SampleSurfaces(depth, kCamera, labels, pixels, spacing, {});
  for (uint32_t pixel = 0; pixel < pixels.size(); pixel += 97) {
    const auto point = SurfaceAt(depth, kCamera, labels, pixel, {});
    ASSERT_TRUE(point.has_value());
    const auto nearest = std::min_element(
        samples.begin(), samples.end(), [&](const SurfacePoint& a, const SurfacePoint& b) {
          return (a.position - point->position).norm() < (b.position - point->position).norm();
        });
    EXPECT_LT(static_cast<double>((nearest->position - point->position).norm()), 1.75 * spacing);
  }
  EXPECT_LT(samples.size(), 1000U);
}

}  // namespace
}  // namespace vantage
