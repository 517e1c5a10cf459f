#include "common/depth_rasterizer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "common/rng.h"

namespace vantage {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

CameraModel SmallCamera() {
  return {.width = 64, .height = 48, .fx = 60.0, .fy = 58.0, .cx = 31.3, .cy = 24.1};
}

// Where the ray through a pixel's centre meets the triangles of a mesh, in double precision.
struct RayHit {
  double depth = kInfinity;  // m along z
  double edge = kInfinity;   // least distance of a barycentric coordinate, of any triangle met or
                             // nearly met, from 0: what is small is a matter of rounding
};

RayHit CastRay(
    const CameraModel& camera, const TriangleMesh& mesh, const Pose& T_camera_mesh, int u, int v) {
  const Eigen::Vector3d ray = camera.Unproject(u, v, 1.0);
  RayHit hit;
  for (const auto& [ia, ib, ic] : mesh.triangles) {
    const Eigen::Vector3d a = T_camera_mesh * mesh.vertices[ia].cast<double>();
    const Eigen::Vector3d b = T_camera_mesh * mesh.vertices[ib].cast<double>();
    const Eigen::Vector3d c = T_camera_mesh * mesh.vertices[ic].cast<double>();
    Eigen::Matrix3d system;
    system << b - a, c - a, -ray;
    if (std::abs(system.determinant()) < 1e-12) {
      hit.edge = 0.0;  // Seen from its side.
      continue;
    }
    const Eigen::Vector3d solved = system.inverse() * -a;
    const double beta = solved[0];
    const double gamma = solved[1];
    const double depth = solved[2];
    const double least = std::min({beta, gamma, 1.0 - beta - gamma});
    if (depth > DepthRasterizer::kNear - 1e-3) {
      hit.edge = std::min({hit.edge, std::abs(least), std::abs(depth - DepthRasterizer::kNear)});
    }
    if (least >= 0.0 && depth >= DepthRasterizer::kNear) hit.depth = std::min(hit.depth, depth);
  }
  return hit;
}

TriangleMesh RandomMesh(int triangles, double size, Rng& rng) {
  TriangleMesh mesh;
  for (uint32_t i = 0; i < static_cast<uint32_t>(triangles); ++i) {
    const Eigen::Vector3d middle = 0.5 * rng.UnitVector();
    for (int corner = 0; corner < 3; ++corner) {
      mesh.vertices.push_back((middle + size * rng.UnitVector()).cast<float>());
    }
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return mesh;
}

// Compares every pixel whose ray is not within rounding of an edge; returns how many those are.
int ExpectSameAsRays(const CameraModel& camera,
                     const TriangleMesh& mesh,
                     const Pose& T_camera_mesh,
                     const DepthRasterizer& rasterizer) {
  constexpr double kRounding = 2e-3;  // of a triangle
  int compared = 0;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const RayHit hit = CastRay(camera, mesh, T_camera_mesh, u, v);
      if (hit.edge < kRounding) continue;
      ++compared;
      const double drawn =
          rasterizer.depth()[static_cast<size_t>(v) * static_cast<size_t>(camera.width) +
                             static_cast<size_t>(u)];
      if (std::isinf(hit.depth)) {
        EXPECT_TRUE(std::isinf(drawn)) << u << " " << v << " drawn " << drawn;
      } else {
        EXPECT_NEAR(drawn, hit.depth, 1e-4 * hit.depth) << u << " " << v;
      }
    }
  }
  return compared;
}

TEST(DepthRasterizer, AgreesWithRayCasting) {
  const CameraModel camera = SmallCamera();
  Rng rng(1);
  DepthRasterizer rasterizer(camera);
  for (int i = 0; i < 20; ++i) {
    const TriangleMesh mesh = RandomMesh(12, 0.3, rng);
    Pose T_camera_mesh = Pose::Identity();
    T_camera_mesh.linear() = rng.Rotation().toRotationMatrix();
    T_camera_mesh.translation().z() = 1.5;
    rasterizer.Clear();
    rasterizer.Draw(mesh, T_camera_mesh);
    EXPECT_GT(ExpectSameAsRays(camera, mesh, T_camera_mesh, rasterizer), 2500);
  }
}

TEST(DepthRasterizer, AgreesWithRayCastingAcrossTheNearPlane) {
  const CameraModel camera = SmallCamera();
  Rng rng(2);
  DepthRasterizer rasterizer(camera);
  int hits = 0;
  for (int i = 0; i < 20; ++i) {
    const TriangleMesh mesh = RandomMesh(6, 0.6, rng);
    Pose T_camera_mesh = Pose::Identity();
    T_camera_mesh.linear() = rng.Rotation().toRotationMatrix();
    T_camera_mesh.translation().z() = 0.2;  // The camera is among the triangles.
    rasterizer.Clear();
    rasterizer.Draw(mesh, T_camera_mesh);
    EXPECT_GT(ExpectSameAsRays(camera, mesh, T_camera_mesh, rasterizer), 2000);
    hits += static_cast<int>(std::count_if(rasterizer.depth().begin(),
                                           rasterizer.depth().end(),
                                           [](float depth) { return std::isfinite(depth); }));
    for (const float depth : rasterizer.depth()) EXPECT_GE(depth, 0.999F * DepthRasterizer::kNear);
  }
  EXPECT_GT(hits, 10'000);
}

TEST(DepthRasterizer, DrawsBothSides) {
  TriangleMesh mesh;
  mesh.vertices = {{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  DepthRasterizer rasterizer(SmallCamera());
  for (int turned = 0; turned < 2; ++turned) {
    Pose T_camera_mesh = Pose::Identity();
    T_camera_mesh.linear() = ExpSo3({0.0, turned * 3.14159265358979, 0.0}).toRotationMatrix();
    T_camera_mesh.translation().z() = 2.0;
    rasterizer.Clear();
    rasterizer.Draw(mesh, T_camera_mesh);
    EXPECT_NEAR(rasterizer.depth()[24 * 64 + 31], 2.0F, 1e-5F);
  }
}

// A quad in the plane z, split in two.
TriangleMesh Quad(double half, double z) {
  const auto h = static_cast<float>(half);
  const auto at = static_cast<float>(z);
  TriangleMesh mesh;
  mesh.vertices = {{-h, -h, at}, {h, -h, at}, {h, h, at}, {-h, h, at}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

TEST(DepthRasterizer, LeavesNoCracksBetweenNeighbours) {
  // A fan of thin triangles that covers the whole image from whatever middle.
  const CameraModel camera = SmallCamera();
  Rng rng(3);
  DepthRasterizer rasterizer(camera);
  for (int i = 0; i < 20; ++i) {
    TriangleMesh fan;
    fan.vertices.emplace_back(static_cast<float>(rng.Uniform(-0.3, 0.3)),
                              static_cast<float>(rng.Uniform(-0.3, 0.3)),
                              1.0F);
    constexpr uint32_t kBlades = 101;
    for (uint32_t j = 0; j < kBlades; ++j) {
      const double angle = 2.0 * 3.14159265358979 * j / kBlades;
      fan.vertices.emplace_back(static_cast<float>(3.0 * std::cos(angle)),
                                static_cast<float>(3.0 * std::sin(angle)),
                                1.0F);
      fan.triangles.push_back({0, 1 + j, 1 + (j + 1) % kBlades});
    }
    rasterizer.Clear();
    rasterizer.Draw(fan, Pose::Identity());
    for (const float depth : rasterizer.depth()) ASSERT_NEAR(depth, 1.0F, 1e-4F);
  }
}

TEST(DepthRasterizer, NearerMeshWinsWhateverTheOrder) {
  const TriangleMesh near_quad = Quad(0.2, 1.0);
  const TriangleMesh far_quad = Quad(3.0, 2.0);
  DepthRasterizer rasterizer(SmallCamera());
  for (const bool near_first : {true, false}) {
    rasterizer.Clear();
    rasterizer.Draw(near_first ? near_quad : far_quad, Pose::Identity(), near_first ? 7 : 9);
    rasterizer.Draw(near_first ? far_quad : near_quad, Pose::Identity(), near_first ? 9 : 7);
    EXPECT_EQ(rasterizer.mesh_ids()[24 * 64 + 31], 7U);
    EXPECT_NEAR(rasterizer.depth()[24 * 64 + 31], 1.0F, 1e-5F);
    EXPECT_EQ(rasterizer.mesh_ids()[0], 9U);
    EXPECT_LT(rasterizer.triangle_ids()[0], 2U);
  }
}

TEST(DepthRasterizer, AtEqualDepthTheFirstWins) {
  const TriangleMesh quad = Quad(3.0, 1.0);
  DepthRasterizer rasterizer(SmallCamera());
  rasterizer.Draw(quad, Pose::Identity(), 1);
  rasterizer.Draw(quad, Pose::Identity(), 2);
  for (const uint32_t id : rasterizer.mesh_ids()) ASSERT_EQ(id, 1U);
}

TEST(DepthRasterizer, TouchedWindowHoldsAllItsPixels) {
  const CameraModel camera = SmallCamera();
  Rng rng(4);
  DepthRasterizer rasterizer(camera);
  for (int i = 0; i < 50; ++i) {
    const TriangleMesh mesh = RandomMesh(2, 0.15, rng);
    Pose T_camera_mesh = Pose::Identity();
    T_camera_mesh.translation() =
        Eigen::Vector3d(rng.Uniform(-1.0, 1.0), rng.Uniform(-1.0, 1.0), rng.Uniform(-0.5, 3.0));
    rasterizer.Clear();
    const PixelWindow window = rasterizer.Draw(mesh, T_camera_mesh);
    for (int v = 0; v < camera.height; ++v) {
      for (int u = 0; u < camera.width; ++u) {
        const size_t index = static_cast<size_t>(v) * 64U + static_cast<size_t>(u);
        if (std::isinf(rasterizer.depth()[index])) {
          EXPECT_EQ(rasterizer.triangle_ids()[index], DepthRasterizer::kNoId);
          continue;
        }
        EXPECT_TRUE(u >= window.u0 && u <= window.u1 && v >= window.v0 && v <= window.v1);
      }
    }
  }
}

TEST(DepthRasterizer, DrawsNothingBehindOrBeside) {
  DepthRasterizer rasterizer(SmallCamera());
  Pose T_camera_mesh = Pose::Identity();
  for (const Eigen::Vector3d& place : {Eigen::Vector3d(0.0, 0.0, -3.0),
                                       Eigen::Vector3d(50.0, 0.0, 1.0),
                                       Eigen::Vector3d(0.0, -50.0, 1.0)}) {
    T_camera_mesh.translation() = place;
    EXPECT_TRUE(rasterizer.Draw(Quad(0.2, 0.0), T_camera_mesh).empty());
  }
  for (const float depth : rasterizer.depth()) ASSERT_TRUE(std::isinf(depth));
}

}  // namespace
}  // namespace vantage
