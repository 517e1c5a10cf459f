#include "perception/segmentation/normals.h"

#include <gtest/gtest.h>

#include <algorithm>

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

TEST(SurfaceAt, IsExactOnPlanes) {
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

TEST(SurfaceAt, SurvivesDisparitySteps) {
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

TEST(SurfaceAt, DoesNotMixSurfacesAcrossDiscontinuitiesAndLabels) {
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

TEST(SurfaceAt, NeedsNeighbors) {
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

TEST(SampleSurfaces, KeepsSpacingAndCoversAll) {
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
