#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "perception/model/mesh_primitives.h"
#include "perception/model/model_generator.h"
#include "perception/model/surface_samples.h"
#include "tests/perception/model_test_support.h"

namespace vantage {
namespace {

std::vector<SurfacePoint> Sample(const TriangleMesh& mesh, double spacing, uint64_t seed = 1) {
  SurfaceSampleParameters parameters;
  parameters.spacing = spacing;
  Rng rng(seed);
  return SampleVisibleSurface(mesh, mesh.Diameter(), parameters, rng);
}

Pose Shift(double x, double y, double z) {
  Pose pose = Pose::Identity();
  pose.translation() = Eigen::Vector3d(x, y, z);
  return pose;
}

TEST(SurfaceSamples, KeepTheirDistanceAndLeaveNoGaps) {
  for (const std::string& name : GeneratedObjectNames()) {
    SCOPED_TRACE(name);
    const TriangleMesh mesh = GenerateObject(name)->mesh;
    const double spacing = 0.05 * mesh.Diameter();
    const std::vector<SurfacePoint> samples = Sample(mesh, 0.05);
    EXPECT_GT(samples.size(), 200U);
    EXPECT_LT(samples.size(), 1000U);
    const MeshDistance distance(mesh);
    for (size_t i = 0; i < samples.size(); ++i) {
      EXPECT_LT(distance.To(samples[i].position.cast<double>()), 1e-6);
      for (size_t j = 0; j < i; ++j) {
        if (samples[i].normal.dot(samples[j].normal) <= -0.49F) continue;
        ASSERT_GT((samples[i].position - samples[j].position).norm(), 0.9999 * spacing);
      }
    }
    // Whatever can be seen is near a sample: compared with a set twice as dense.
    double widest = 0.0;
    for (const SurfacePoint& point : Sample(mesh, 0.025, 2)) {
      double nearest = std::numeric_limits<double>::infinity();
      for (const SurfacePoint& sample : samples) {
        nearest = std::min(nearest, static_cast<double>((sample.position - point.position).norm()));
      }
      widest = std::max(widest, nearest);
    }
    EXPECT_LT(widest, 1.5 * spacing);
  }
}

TEST(SurfaceSamples, NormalsAreThoseOfASphere) {
  const TriangleMesh sphere = Ellipsoid({0.05, 0.05, 0.05}, 48);
  for (const SurfacePoint& sample : Sample(sphere, 0.05)) {
    EXPECT_NEAR(sample.normal.norm(), 1.0F, 1e-5F);
    // A facet's own normal would be off by up to 3.7 degrees.
    EXPECT_GT(sample.normal.dot(sample.position.normalized()), std::cos(1.5 * kDegree));
  }
}

TEST(SurfaceSamples, NormalsKeepCreases) {
  // The bevels meet the sides at 45 degrees: above the crease angle.
  const TriangleMesh box = BeveledBox({0.06, 0.08, 0.1}, 0.004);
  size_t on_sides = 0;
  const std::vector<SurfacePoint> samples = Sample(box, 0.04);
  for (const SurfacePoint& sample : samples) {
    const Eigen::Vector3f size = sample.normal.cwiseAbs();
    if (size.maxCoeff() > 0.999F) ++on_sides;
    const bool bevel = std::abs(size.maxCoeff() - 0.7071F) < 0.15F || size.maxCoeff() > 0.999F ||
                       std::abs(size.maxCoeff() - 0.5773F) < 0.15F;
    EXPECT_TRUE(bevel) << sample.normal.transpose();
  }
  EXPECT_GT(on_sides, samples.size() * 8 / 10);
}

TEST(SurfaceSamples, HiddenSurfacesGetNone) {
  // A small ball inside a closed box, and two boxes that run through one another.
  TriangleMesh mesh = BeveledBox({0.08, 0.08, 0.08}, 0.004);
  Append(Ellipsoid({0.02, 0.02, 0.02}, 24), Shift(0.0, 0.0, 0.04), &mesh);
  Append(BeveledBox({0.16, 0.03, 0.03}, 0.004), Shift(0.0, 0.0, 0.025), &mesh);
  int on_arms = 0;
  for (const SurfacePoint& sample : Sample(mesh, 0.03)) {
    const Eigen::Vector3f p = sample.position - Eigen::Vector3f(0.0F, 0.0F, 0.04F);
    const float depth_inside = 0.04F - p.cwiseAbs().maxCoeff();
    EXPECT_LT(depth_inside, 0.0045F) << p.transpose();
    on_arms += std::abs(p.x()) > 0.045F ? 1 : 0;
  }
  EXPECT_GT(on_arms, 50);
}

TEST(SurfaceSamples, InsideOfAnOpenCupIsSeen) {
  const TriangleMesh mug = GenerateObject("mug")->mesh;
  int inside = 0;
  for (const SurfacePoint& sample : Sample(mug, 0.05)) {
    const Eigen::Vector2f across = sample.position.head<2>();
    if (across.norm() < 0.037F && sample.position.z() > 0.006F && sample.position.z() < 0.09F) {
      ++inside;
      EXPECT_LT(sample.normal.head<2>().dot(across), 1e-4F);
    }
  }
  EXPECT_GT(inside, 100);
}

TEST(SurfaceSamples, NormalsOfAMeshInsideOutAreTurnedOutward) {
  TriangleMesh sphere = Ellipsoid({0.05, 0.05, 0.05}, 48);
  for (auto& triangle : sphere.triangles) std::swap(triangle[0], triangle[1]);
  for (const SurfacePoint& sample : Sample(sphere, 0.05)) {
    EXPECT_GT(sample.normal.dot(sample.position.normalized()), 0.9F);
  }
}

TEST(SurfaceSamples, SameSeedSameSamples) {
  const TriangleMesh mesh = GenerateObject("bracket")->mesh;
  const std::vector<SurfacePoint> first = Sample(mesh, 0.05, 7);
  const std::vector<SurfacePoint> again = Sample(mesh, 0.05, 7);
  const std::vector<SurfacePoint> other = Sample(mesh, 0.05, 8);
  ASSERT_EQ(first.size(), again.size());
  for (size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].position, again[i].position);
    EXPECT_EQ(first[i].normal, again[i].normal);
  }
  EXPECT_NE(first.front().position, other.front().position);
}

TEST(SurfaceSampleParameters, ValidateNamesTheValue) {
  EXPECT_TRUE(SurfaceSampleParameters{}.Validate().ok());
  const auto message = [](SurfaceSampleParameters parameters) {
    return parameters.Validate().error().message;
  };
  EXPECT_NE(message({.spacing = 0.0}).find("spacing = 0"), std::string::npos);
  EXPECT_NE(message({.crease = -1.0}).find("crease"), std::string::npos);
  EXPECT_NE(message({.directions = 0}).find("directions"), std::string::npos);
  EXPECT_NE(message({.image_size = 1}).find("image size"), std::string::npos);
}

}  // namespace
}  // namespace vantage
