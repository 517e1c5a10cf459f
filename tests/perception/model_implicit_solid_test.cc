#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "common/rng.h"
#include "perception/model/implicit_solid.h"
#include "perception/model/mesh_check.h"

namespace vantage {
namespace {

constexpr double kPi = std::numbers::pi;

Pose At(double x, double y, double z) { return Pose(Eigen::Translation3d(x, y, z)); }

// A point above the ground, where no cut disturbs.
Eigen::Vector3d RandomPoint(Rng& rng) {
  return {rng.Uniform(-0.1, 0.1), rng.Uniform(-0.1, 0.1), rng.Uniform(0.1, 0.3)};
}

TEST(ImplicitSolid, LimbIsTheUnionOfTheBallsAlongIt) {
  Rng rng(1);
  for (int trial = 0; trial < 20; ++trial) {
    std::vector<Ball> balls;
    for (int i = 0; i < 3; ++i) {
      // Apart by more than their radii differ.
      balls.push_back({Eigen::Vector3d(0.05 * i, rng.Uniform(-0.05, 0.05), rng.Uniform(0.15, 0.25)),
                       rng.Uniform(0.005, 0.04)});
    }
    ImplicitSolid solid;
    solid.AddLimb(balls, 0.0);
    for (int i = 0; i < 20; ++i) {
      const Eigen::Vector3d point = RandomPoint(rng);
      double expected = std::numeric_limits<double>::infinity();
      constexpr int kSteps = 5000;
      for (size_t j = 0; j + 1 < balls.size(); ++j) {
        for (int step = 0; step <= kSteps; ++step) {
          const double t = static_cast<double>(step) / kSteps;
          const Eigen::Vector3d center = (1.0 - t) * balls[j].center + t * balls[j + 1].center;
          const double radius = (1.0 - t) * balls[j].radius + t * balls[j + 1].radius;
          expected = std::min(expected, (point - center).norm() - radius);
        }
      }
      EXPECT_NEAR(solid.Distance(point), expected, 1e-6);
    }
  }
}

TEST(ImplicitSolid, EllipsoidIsExactOnTheSurfaceAndToFirstOrderNextToIt) {
  Rng rng(2);
  const Eigen::Vector3d radii(0.05, 0.02, 0.03);
  const Pose T = At(0.01, 0.02, 0.2) * Pose(rng.Rotation());
  ImplicitSolid solid;
  solid.AddEllipsoid(T, radii, 0.0);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d unit = rng.UnitVector();
    const Eigen::Vector3d on_surface = unit.cwiseProduct(radii);
    const Eigen::Vector3d normal = unit.cwiseQuotient(radii).normalized();
    EXPECT_NEAR(solid.Distance(T * on_surface), 0.0, 1e-12);
    for (const double offset : {-1e-4, 1e-4}) {
      EXPECT_NEAR(solid.Distance(T * (on_surface + offset * normal)), offset, 2e-6);
    }
  }
  // At its very center, where the formula has no value.
  EXPECT_LT(solid.Distance(T.translation()), -0.01);
}

TEST(ImplicitSolid, BlendFillsAtMostAQuarterAndOnlyWhereBothAreNear) {
  constexpr double kBlend = 0.012;
  const Ball a{{-0.02, 0.0, 0.2}, 0.03};
  const Ball b{{0.02, 0.0, 0.2}, 0.025};
  ImplicitSolid solid;
  solid.AddLimb({a}, 0.0);
  solid.AddLimb({b}, kBlend);
  Rng rng(3);
  double most = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d point = RandomPoint(rng);
    const double to_a = (point - a.center).norm() - a.radius;
    const double to_b = (point - b.center).norm() - b.radius;
    const double filled = std::min(to_a, to_b) - solid.Distance(point);
    EXPECT_GE(filled, -1e-12);
    EXPECT_LE(filled, 0.25 * kBlend + 1e-12);
    if (std::abs(to_a - to_b) >= kBlend) {
      EXPECT_NEAR(filled, 0.0, 1e-12);
    }
    most = std::max(most, filled);
  }
  EXPECT_GT(most, 0.24 * kBlend);
}

TEST(ImplicitSolid, MeshIsClosedOnTheSurfaceAndOfTheRightVolume) {
  // A ball that the ground cuts at a third of its height, and a thin pole far from it.
  const double radius = 0.05;
  const double height = 4.0 / 3.0 * radius;  // of what is left
  ImplicitSolid solid;
  solid.AddLimb({{{0.0, 0.0, height - radius}, radius}}, 0.0);
  solid.AddLimb({{{0.1, 0.0, 0.03}, 0.008}, {{0.1, 0.02, 0.08}, 0.008}}, 0.0);
  constexpr double kCell = 0.004;
  TriangleMesh mesh = solid.Polygonize(kCell);
  double exact = 0.0;
  for (const Eigen::Vector3f& vertex : mesh.vertices) {
    EXPECT_GE(vertex.z(), 0.0F);
    const double distance = solid.Distance(vertex.cast<double>());
    EXPECT_LT(std::abs(distance), 0.25 * kCell);  // At the rim a vertex cannot meet both surfaces.
    exact += std::abs(distance) < 1e-6 ? 1.0 / static_cast<double>(mesh.vertices.size()) : 0.0;
  }
  EXPECT_GT(exact, 0.9);
  const Result<MeshMending> mending = CheckAndMendMesh(&mesh);
  ASSERT_TRUE(mending.ok());
  EXPECT_EQ(mending->open_edges, 0U);
  EXPECT_EQ(mending->odd_edges, 0U);
  EXPECT_FALSE(mending->flipped);
  const double ball = kPi * height * height * (radius - height / 3.0);
  const double length = std::hypot(0.02, 0.05);
  const double pole = kPi * 0.008 * 0.008 * (length + 4.0 / 3.0 * 0.008);
  EXPECT_NEAR(SignedVolume(mesh), ball + pole, 0.01 * (ball + pole));
}

TEST(ImplicitSolid, FinerGridsComeNearerToTheVolume) {
  ImplicitSolid solid;
  solid.AddEllipsoid(At(0.003, 0.001, 0.1), {0.05, 0.03, 0.02}, 0.0);
  const double volume = 4.0 / 3.0 * kPi * 0.05 * 0.03 * 0.02;
  const auto error = [&](double cell) {
    return std::abs(SignedVolume(solid.Polygonize(cell)) / volume - 1.0);
  };
  // Of second order: half the cell, a quarter of the error.
  EXPECT_LT(error(0.004), 0.02);
  EXPECT_LT(error(0.002), 0.4 * error(0.004));
}

}  // namespace
}  // namespace vantage
