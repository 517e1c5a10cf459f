#include "fusion/symmetry/measured_symmetry.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "fusion/symmetry/nearest_surface.h"

namespace vantage {
namespace {

using Polygon = std::vector<Eigen::Vector2d>;

// The solid between a polygon at z = 0 and the same one scaled by `taper` at z = height. The
// polygon runs counter-clockwise and is seen whole from the origin.
TriangleMesh Prism(const Polygon& polygon, double height, double taper = 1.0) {
  TriangleMesh mesh;
  const auto count = static_cast<uint32_t>(polygon.size());
  for (const double z : {0.0, height}) {
    const double scale = z > 0.0 ? taper : 1.0;
    for (const Eigen::Vector2d& p : polygon) {
      mesh.vertices.push_back(Eigen::Vector3d(scale * p.x(), scale * p.y(), z).cast<float>());
    }
  }
  for (const double z : {0.0, height}) {
    mesh.vertices.push_back(Eigen::Vector3d(0.0, 0.0, z).cast<float>());
  }
  for (uint32_t i = 0; i < count; ++i) {
    const uint32_t next = (i + 1) % count;
    mesh.triangles.push_back({i, next, count + next});
    mesh.triangles.push_back({i, count + next, count + i});
    mesh.triangles.push_back({next, i, 2 * count});
    mesh.triangles.push_back({count + i, count + next, 2 * count + 1});
  }
  return mesh;
}

Polygon Regular(int corners, double radius) {
  Polygon polygon;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / corners;
    polygon.push_back(radius * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  return polygon;
}

Polygon Rectangle(double x, double y) {
  return {{0.5 * x, -0.5 * y}, {0.5 * x, 0.5 * y}, {-0.5 * x, 0.5 * y}, {-0.5 * x, -0.5 * y}};
}

TriangleMesh Ball() {
  TriangleMesh mesh;
  constexpr uint32_t kAround = 48;
  constexpr uint32_t kDown = 24;
  for (uint32_t i = 0; i <= kDown; ++i) {
    for (uint32_t j = 0; j < kAround; ++j) {
      const double polar = std::numbers::pi * i / kDown;
      const double azimuth = 2.0 * std::numbers::pi * j / kAround;
      mesh.vertices.push_back(Eigen::Vector3d(std::sin(polar) * std::cos(azimuth),
                                              std::sin(polar) * std::sin(azimuth),
                                              std::cos(polar))
                                  .cast<float>());
      if (i == kDown) continue;
      const uint32_t here = i * kAround + j;
      const uint32_t beside = i * kAround + (j + 1) % kAround;
      mesh.triangles.push_back({here, here + kAround, beside});
      mesh.triangles.push_back({beside, here + kAround, beside + kAround});
    }
  }
  return mesh;
}

// Moves the mesh and measures it.
Result<FoundSymmetry> MeasureMoved(const TriangleMesh& mesh, const Eigen::Quaterniond& turn) {
  Pose T_moved_mesh = Pose::Identity();
  T_moved_mesh.linear() = turn.toRotationMatrix();
  T_moved_mesh.translation() = Eigen::Vector3d(0.3, -0.2, 0.1);
  TriangleMesh moved;
  Append(mesh, T_moved_mesh, &moved);
  return MeasureSymmetry(moved, {.num_samples = 150});
}

// Every element is one of the expected group turned like the mesh, and there are as many.
void ExpectGroup(const TriangleMesh& mesh, const SymmetryGroup& expected, uint64_t seed) {
  Rng rng(seed);
  const Eigen::Quaterniond turn = rng.Rotation();
  const Result<FoundSymmetry> found = MeasureMoved(mesh, turn);
  ASSERT_TRUE(found.ok()) << found.error().message;
  const SymmetryGroup* measured = &found->group;
  EXPECT_GT(found->confidence, 0.5);
  ASSERT_EQ(measured->kind, SymmetryGroup::Kind::kFinite);
  EXPECT_EQ(measured->elements.size(), expected.elements.size());
  EXPECT_EQ(measured->elements.front().coeffs(), Eigen::Quaterniond::Identity().coeffs());
  for (const Eigen::Quaterniond& a : measured->elements) {
    const Eigen::Quaterniond in_mesh = turn.conjugate() * a * turn;
    EXPECT_LT(SymmetricAngle(expected, Eigen::Quaterniond::Identity(), in_mesh), 0.05 * kDegree);
    for (const Eigen::Quaterniond& b : measured->elements) {
      // Closed, to rounding: the angle to the group of the product.
      EXPECT_LT(SymmetricAngle(*measured, Eigen::Quaterniond::Identity(), a * b), 1e-6);
      if (&a != &b) {
        EXPECT_GT(GeodesicAngle(a, b), 0.1);
      }
    }
  }
}

void ExpectContinuous(const TriangleMesh& mesh, bool flips, uint64_t seed) {
  Rng rng(seed);
  const Eigen::Quaterniond turn = rng.Rotation();
  const Result<FoundSymmetry> found = MeasureMoved(mesh, turn);
  ASSERT_TRUE(found.ok()) << found.error().message;
  const SymmetryGroup* measured = &found->group;
  EXPECT_GT(found->confidence, 0.5);
  ASSERT_EQ(measured->kind, SymmetryGroup::Kind::kContinuous);
  EXPECT_EQ(measured->flips, flips);
  EXPECT_LT(measured->axis.cross(turn * Eigen::Vector3d::UnitZ()).norm(), 0.2 * kDegree);
}

TEST(MeasuredSymmetry, Boxes) {
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX();
  const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
  ExpectGroup(Prism(Rectangle(0.10, 0.06), 0.03), SymmetryGroup::Dihedral(2, z, x), 1);
  ExpectGroup(Prism(Rectangle(0.05, 0.05), 0.12), SymmetryGroup::Dihedral(4, z, x), 2);
  ExpectGroup(Prism(Rectangle(0.05, 0.05), 0.12, 0.7), SymmetryGroup::Cyclic(4, z), 3);
}

TEST(MeasuredSymmetry, CubeHas24Rotations) {
  SymmetryGroup cube;
  cube.elements.clear();
  for (int turns = 0; turns < 4; ++turns) {
    const Eigen::Quaterniond about_z = ExpSo3({0.0, 0.0, 0.5 * std::numbers::pi * turns});
    for (const Eigen::Vector3d& up : {Eigen::Vector3d(0, 0, 0),
                                      Eigen::Vector3d(1, 0, 0),
                                      Eigen::Vector3d(2, 0, 0),
                                      Eigen::Vector3d(3, 0, 0),
                                      Eigen::Vector3d(0, 1, 0),
                                      Eigen::Vector3d(0, 3, 0)}) {
      cube.elements.push_back(ExpSo3(0.5 * std::numbers::pi * up) * about_z);
    }
  }
  ExpectGroup(Prism(Rectangle(1.0, 1.0), 1.0), cube, 4);
}

TEST(MeasuredSymmetry, HexagonalPrismWithAndWithoutANotch) {
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX();
  const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
  ExpectGroup(Prism(Regular(6, 0.05), 0.04), SymmetryGroup::Dihedral(6, z, x), 5);
  // One corner pressed in: the half turn about it is left.
  Polygon notched = Regular(6, 0.05);
  notched[0] *= 0.6;
  ExpectGroup(Prism(notched, 0.04), SymmetryGroup::Cyclic(2, x), 6);
}

TEST(MeasuredSymmetry, WheelOf24TeethIsFiniteThoughFinerThanTheGridTells) {
  Polygon wheel = Regular(48, 0.05);
  for (size_t i = 0; i < wheel.size(); i += 2) wheel[i] *= 0.8;
  ExpectGroup(Prism(wheel, 0.03, 0.9), SymmetryGroup::Cyclic(24, Eigen::Vector3d::UnitZ()), 7);
}

TEST(MeasuredSymmetry, BracketsHaveNoneUnlessTheirLegsAreEqual) {
  const auto bracket = [](double leg) {
    const double w = 0.01;  // Half the width of the legs, about the origin in the corner.
    return Prism({{-w, -w}, {0.08, -w}, {0.08, w}, {w, w}, {w, leg}, {-w, leg}}, 0.04);
  };
  ExpectGroup(bracket(0.05), SymmetryGroup::None(), 8);
  ExpectGroup(bracket(0.08), SymmetryGroup::Cyclic(2, Eigen::Vector3d(1.0, 1.0, 0.0)), 9);
}

TEST(MeasuredSymmetry, CylinderAndCone) {
  ExpectContinuous(Prism(Regular(40, 0.03), 0.1), true, 10);
  ExpectContinuous(Prism(Regular(40, 0.03), 0.1, 0.1), false, 11);
}

TEST(MeasuredSymmetry, BallIsASphere) {
  const Result<FoundSymmetry> found = MeasureSymmetry(Ball(), {.num_samples = 100});
  ASSERT_TRUE(found.ok());
  EXPECT_TRUE(found->is_sphere);
  EXPECT_GT(found->confidence, 0.9);
  EXPECT_LT(found->center.norm(), 0.01);
  EXPECT_NE(FoundSymmetryText(*found).find("can't be told"), std::string::npos);
}

TEST(MeasuredSymmetry, RefusesWhatItCanNotMeasure) {
  EXPECT_FALSE(MeasureSymmetry(TriangleMesh{}).ok());
  TriangleMesh mesh = Prism(Rectangle(1.0, 2.0), 3.0);
  mesh.triangles.push_back({0, 1, 10});
  EXPECT_FALSE(MeasureSymmetry(mesh).ok());
  mesh.triangles.back() = {0, 1, 2};
  mesh.vertices[3].x() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(MeasureSymmetry(mesh).ok());
  TriangleMesh flat;
  flat.vertices = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  flat.triangles = {{0, 1, 2}};
  EXPECT_FALSE(MeasureSymmetry(flat).ok());

  using P = MeasuredSymmetryParameters;
  EXPECT_TRUE(P{}.Validate().ok());
  EXPECT_FALSE(P{.k = 1}.Validate().ok());
  EXPECT_FALSE(P{.num_samples = 0}.Validate().ok());
  EXPECT_FALSE(P{.tolerance = 0.0}.Validate().ok());
  EXPECT_FALSE(P{.least_tolerance = 0.02}.Validate().ok());
  EXPECT_FALSE(P{.unevenness_factor = 0.5}.Validate().ok());
  EXPECT_FALSE(P{.tolerance = std::nan("")}.Validate().ok());
}

TEST(NearestSurface, IsTheNearestOfDenseSamples) {
  Rng rng(12);
  const TriangleMesh mesh = Prism(Regular(7, 1.0), 1.5, 0.4);
  const NearestSurface surface(mesh);
  const std::vector<SurfacePoint> samples = SampleSurface(mesh, 40000, rng);
  for (int trial = 0; trial < 200; ++trial) {
    const Eigen::Vector3d point = 2.0 * rng.Uniform() * rng.UnitVector();
    const NearestSurface::Hit hit = surface.Nearest(point);
    double nearest = 10.0;
    for (const SurfacePoint& sample : samples) {
      nearest = std::min(nearest, (sample.position.cast<double>() - point).norm());
    }
    EXPECT_LE(hit.distance, nearest + 1e-6);
    EXPECT_NEAR(hit.distance, nearest, 0.05);  // Samples lie some 0.02 apart.
    EXPECT_NEAR((hit.point - point).norm(), hit.distance, 1e-12);
    EXPECT_NEAR(surface.Nearest(hit.point).distance, 0.0, 1e-9);
  }
}

}  // namespace
}  // namespace vantage
