#include "perception/verification/mesh_decimation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "perception/model/model_generator.h"
#include "perception/verification/mesh_topology.h"
#include "tests/perception/test_scenes.h"

namespace vantage {
namespace {

// m, squared
float SquaredDistance(const Eigen::Vector3f& p, const TriangleMesh& mesh, size_t triangle) {
  const auto& [ia, ib, ic] = mesh.triangles[triangle];
  const std::array<Eigen::Vector3f, 3> corner = {
      mesh.vertices[ia], mesh.vertices[ib], mesh.vertices[ic]};
  const Eigen::Vector3f normal = mesh.ScaledNormal(triangle).normalized();
  bool is_inside = true;
  float least = std::numeric_limits<float>::infinity();
  for (size_t i = 0; i < 3; ++i) {
    const Eigen::Vector3f edge = corner[(i + 1) % 3] - corner[i];
    const Eigen::Vector3f from = p - corner[i];
    is_inside = is_inside && normal.dot(edge.cross(from)) >= 0.0F;
    const float along = std::clamp(from.dot(edge) / edge.squaredNorm(), 0.0F, 1.0F);
    least = std::min(least, (from - along * edge).squaredNorm());
  }
  if (!is_inside) return least;
  const float away = normal.dot(p - corner[0]);
  return std::min(least, away * away);
}

// Largest distance (m) of points of one surface from another.
double Deviation(const TriangleMesh& from, const TriangleMesh& to) {
  Rng rng(1);
  double largest = 0.0;
  for (const SurfacePoint& point : SampleSurface(from, 400, rng)) {
    float least = std::numeric_limits<float>::infinity();
    for (size_t i = 0; i < to.triangles.size(); ++i) {
      least = std::min(least, SquaredDistance(point.position, to, i));
    }
    largest = std::max(largest, std::sqrt(static_cast<double>(least)));
  }
  return largest;
}

TEST(DecimateMesh, KeepsTheSurfaceOfGeneratedObjects) {
  for (const char* name : {"duck", "mug", "bracket"}) {
    SCOPED_TRACE(name);
    const TriangleMesh mesh = GenerateObject(name).value().mesh;
    const double diameter = mesh.Diameter();
    for (const LevelOfDetail& level : {kCoarseLevel, kFineLevel}) {
      const TriangleMesh fewer = DecimateMesh(mesh, level);
      EXPECT_LE(fewer.triangles.size(), level.max_triangles);
      EXPECT_LT(fewer.vertices.size(), mesh.vertices.size() + 1);
      EXPECT_LT(Deviation(fewer, mesh), 2.0 * level.max_error * diameter);
      EXPECT_LT(Deviation(mesh, fewer), 2.0 * level.max_error * diameter);
      EXPECT_EQ(IsClosed(WeldVertices(fewer)), IsClosed(WeldVertices(mesh)));
    }
  }
}

TEST(DecimateMesh, FlatFacesNeedFewTriangles) {
  const TriangleMesh box = MakeBox({-0.05F, -0.03F, -0.02F}, {0.05F, 0.03F, 0.02F}, 40);
  const TriangleMesh fewer = DecimateMesh(box, 12, 1e-4);
  EXPECT_LE(fewer.triangles.size(), 40U);
  EXPECT_NEAR(fewer.Area(), box.Area(), 1e-3 * box.Area());
  EXPECT_TRUE(IsClosed(fewer));
}

TEST(DecimateMesh, StopsAtTheError) {
  const TriangleMesh mesh = GenerateObject("cat").value().mesh;
  EXPECT_GT(DecimateMesh(mesh, 50, 1e-5).triangles.size(), 500U);
}

TEST(DecimateMesh, KeepsBordersOfAnOpenSheet) {
  TriangleMesh sheet = MakeBox({-0.1F, -0.1F, 0.0F}, {0.1F, 0.1F, 0.1F}, 30);
  std::erase_if(sheet.triangles, [&](const auto& triangle) {
    return std::any_of(triangle.begin(), triangle.end(), [&](uint32_t vertex) {
      return sheet.vertices[vertex].z() > 0.0F;
    });
  });
  const TriangleMesh fewer = DecimateMesh(sheet, 20, 1e-3);
  EXPECT_LT(fewer.triangles.size(), sheet.triangles.size() / 4);
  EXPECT_NEAR(fewer.Area(), 0.04, 1e-4);
}

TEST(DecimateMesh, WithstandsWhatIsHardlyAMesh) {
  EXPECT_TRUE(DecimateMesh(TriangleMesh{}, 10, 1e-3).triangles.empty());
  TriangleMesh one;
  one.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  one.triangles = {{0, 1, 2}};
  EXPECT_EQ(DecimateMesh(one, 10, 1e-3).triangles.size(), 1U);
  EXPECT_LE(DecimateMesh(one, 0, 1e-3).triangles.size(), 1U);
  // Every edge has four triangles; some triangles are nothing.
  TriangleMesh doubled = MakeBox({0.0F, 0.0F, 0.0F}, {0.1F, 0.1F, 0.1F}, 10);
  Append(TriangleMesh(doubled), Pose::Identity(), &doubled);
  doubled.vertices.emplace_back(std::nanf(""), 0.0F, 0.0F);
  doubled.triangles.push_back({0, 1, static_cast<uint32_t>(doubled.vertices.size() - 1)});
  doubled.triangles.push_back({0, 1, 0xfffffff0U});
  doubled.triangles.push_back({7, 7, 7});
  const TriangleMesh fewer = DecimateMesh(doubled, 100, 1e-3);
  EXPECT_FALSE(fewer.triangles.empty());
  for (const auto& triangle : fewer.triangles) {
    for (const uint32_t vertex : triangle) {
      ASSERT_LT(vertex, fewer.vertices.size());
      EXPECT_TRUE(fewer.vertices[vertex].allFinite());
    }
  }
}

}  // namespace
}  // namespace vantage
