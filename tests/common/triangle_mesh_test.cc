#include "common/triangle_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace vantage {
namespace {

// A box from the origin to `size`, outward winding.
TriangleMesh Box(const Eigen::Vector3f& size) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3f corner(static_cast<float>(i & 1),
                                 static_cast<float>((i >> 1) & 1),
                                 static_cast<float>((i >> 2) & 1));
    mesh.vertices.push_back(corner.cwiseProduct(size));
  }
  mesh.triangles = {{0, 2, 1},
                    {1, 2, 3},
                    {4, 5, 6},
                    {5, 7, 6},
                    {0, 1, 4},
                    {1, 5, 4},
                    {2, 6, 3},
                    {3, 6, 7},
                    {0, 4, 2},
                    {2, 4, 6},
                    {1, 3, 5},
                    {3, 7, 5}};
  return mesh;
}

TriangleMesh RandomMesh(int triangles, Rng& rng) {
  TriangleMesh mesh;
  for (int i = 0; i < 3 * triangles; ++i) {
    mesh.vertices.push_back((rng.Uniform(0.1, 1.0) * rng.UnitVector()).cast<float>());
  }
  for (uint32_t i = 0; i < static_cast<uint32_t>(triangles); ++i) {
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return mesh;
}

TEST(TriangleMesh, MeasuresABox) {
  const TriangleMesh box = Box({1.0F, 2.0F, 3.0F});
  EXPECT_NEAR(box.Area(), 22.0, 1e-6);
  EXPECT_LE((box.SurfaceCentroid() - Eigen::Vector3d(0.5, 1.0, 1.5)).norm(), 1e-7);
  EXPECT_EQ(box.Bounds().sizes(), Eigen::Vector3f(1.0F, 2.0F, 3.0F));
  EXPECT_NEAR(box.Diameter(), std::sqrt(14.0), 0.01 * std::sqrt(14.0));
}

TEST(TriangleMesh, NormalsPointOutward) {
  const TriangleMesh box = Box({1.0F, 2.0F, 3.0F});
  const Eigen::Vector3f middle(0.5F, 1.0F, 1.5F);
  for (size_t i = 0; i < box.triangles.size(); ++i) {
    EXPECT_GT(box.ScaledNormal(i).dot(box.vertices[box.triangles[i][0]] - middle), 0.0F) << i;
  }
}

TEST(TriangleMesh, CentroidIsOfTheSurfaceNotOfTheVertices) {
  // A large and a small triangle far apart.
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {3, 0, 0}, {0, 3, 0}, {10, 0, 0}, {10.3F, 0, 0}, {10, 0.3F, 0}};
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
  const double expected = (4.5 * 1.0 + 0.045 * 10.1) / 4.545;
  EXPECT_NEAR(mesh.SurfaceCentroid().x(), expected, 1e-6);
}

TEST(TriangleMesh, DiameterIsWithinAPercentOfBruteForce) {
  Rng rng(1);
  for (int i = 0; i < 20; ++i) {
    const TriangleMesh mesh = RandomMesh(30, rng);
    double largest = 0.0;
    for (const Eigen::Vector3f& a : mesh.vertices) {
      for (const Eigen::Vector3f& b : mesh.vertices) {
        largest = std::max(largest, static_cast<double>((a - b).norm()));
      }
    }
    EXPECT_LE(mesh.Diameter(), largest * (1.0 + 1e-6));
    EXPECT_GE(mesh.Diameter(), 0.99 * largest);
  }
}

TEST(SampleSurface, LiesOnTheSurfaceUniformly) {
  const TriangleMesh box = Box({1.0F, 2.0F, 3.0F});
  Rng rng(2);
  constexpr size_t kCount = 44'000;
  std::vector<int> by_face(6, 0);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const SurfacePoint& point : SampleSurface(box, kCount, rng)) {
    ASSERT_NEAR(point.normal.norm(), 1.0F, 1e-5F);
    Eigen::Index axis = 0;
    point.normal.cwiseAbs().maxCoeff(&axis);
    const bool upper = point.normal[axis] > 0.0F;
    ASSERT_NEAR(point.position[axis], upper ? box.Bounds().max()[axis] : 0.0F, 1e-5F);
    ++by_face[static_cast<size_t>(2 * axis + (upper ? 1 : 0))];
    mean += point.position.cast<double>() / kCount;
  }
  // Areas 6, 6, 3, 3, 2, 2 of 22: counts within five standard deviations.
  const std::vector<double> areas = {6, 6, 3, 3, 2, 2};
  for (size_t i = 0; i < areas.size(); ++i) {
    const double share = areas[i] / 22.0;
    const double deviation = std::sqrt(kCount * share * (1.0 - share));
    EXPECT_NEAR(by_face[i], kCount * share, 5.0 * deviation) << i;
  }
  EXPECT_LE((mean - Eigen::Vector3d(0.5, 1.0, 1.5)).norm(), 0.03);
}

TEST(SampleSurface, SameSeedSamePoints) {
  const TriangleMesh box = Box({1.0F, 2.0F, 3.0F});
  Rng first(3);
  Rng again(3);
  const std::vector<SurfacePoint> a = SampleSurface(box, 100, first);
  const std::vector<SurfacePoint> b = SampleSurface(box, 100, again);
  for (size_t i = 0; i < a.size(); ++i) EXPECT_EQ(a[i].position, b[i].position);
}

TEST(Append, MovesVerticesAndRenumbersTriangles) {
  TriangleMesh mesh = Box({1.0F, 1.0F, 1.0F});
  Pose T_mesh_part = Pose::Identity();
  T_mesh_part.translation() = Eigen::Vector3d(5.0, 0.0, 0.0);
  T_mesh_part.linear() = ExpSo3({0.0, 0.0, 0.5 * 3.14159265358979}).toRotationMatrix();
  Append(Box({2.0F, 1.0F, 1.0F}), T_mesh_part, &mesh);
  ASSERT_EQ(mesh.vertices.size(), 16U);
  ASSERT_EQ(mesh.triangles.size(), 24U);
  EXPECT_NEAR(mesh.Area(), 6.0 + 10.0, 1e-5);
  EXPECT_LE((mesh.vertices[9] - Eigen::Vector3f(5.0F, 2.0F, 0.0F)).norm(), 1e-5F);
  for (const uint32_t index : mesh.triangles[23]) EXPECT_GE(index, 8U);
}

}  // namespace
}  // namespace vantage
