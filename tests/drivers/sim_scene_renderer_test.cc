#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "common/rng.h"
#include "common/so3.h"
#include "drivers/sim/scene_renderer.h"

namespace vantage {
namespace {

struct Hit {
  double depth = std::numeric_limits<double>::infinity();
  double cosine = 0.0;
  uint32_t surface = RenderedView::kNoSurface;
};

/// Moeller-Trumbore over every triangle, in double.
void CastRay(const TriangleMesh& mesh,
             const Pose& T_camera_mesh,
             const Eigen::Vector3d& ray,
             uint32_t surface,
             Hit* best) {
  for (const auto& [ia, ib, ic] : mesh.triangles) {
    const Eigen::Vector3d a = T_camera_mesh * mesh.vertices[ia].cast<double>();
    const Eigen::Vector3d ab = T_camera_mesh * mesh.vertices[ib].cast<double>() - a;
    const Eigen::Vector3d ac = T_camera_mesh * mesh.vertices[ic].cast<double>() - a;
    const Eigen::Vector3d p = ray.cross(ac);
    const double determinant = ab.dot(p);
    if (std::abs(determinant) < 1e-15) continue;
    const double u = -a.dot(p) / determinant;
    const Eigen::Vector3d q = (-a).cross(ab);
    const double v = ray.dot(q) / determinant;
    const double depth = ac.dot(q) / determinant;
    if (u < 0.0 || v < 0.0 || u + v > 1.0 || depth <= 0.0 || depth >= best->depth) continue;
    best->depth = depth;
    best->cosine = std::abs(ab.cross(ac).normalized().dot(ray.normalized()));
    best->surface = surface;
  }
}

TriangleMesh Box(float x, float y, float z) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.emplace_back(
        (i & 1) != 0 ? x : -x, (i & 2) != 0 ? y : -y, (i & 4) != 0 ? z : 0.0F);
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

TriangleMesh PlaneAt(double height, double half) {
  const auto h = static_cast<float>(half);
  const auto z = static_cast<float>(height);
  TriangleMesh mesh;
  mesh.vertices = {{-h, -h, z}, {h, -h, z}, {h, h, z}, {-h, h, z}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

SimScene TwoBoxes() {
  SimScene scene;
  scene.table = SimPlane{.height = 0.0, .size = {0.8, 0.8}};
  scene.floor = SimPlane{.height = -0.7, .size = {4.0, 4.0}};
  Pose first = Pose::Identity();
  first.translation() = Eigen::Vector3d(-0.1, 0.05, 0.0);
  first.linear() = ExpSo3({0.0, 0.0, 0.5}).toRotationMatrix();
  Pose second = Pose::Identity();
  second.translation() = Eigen::Vector3d(0.12, -0.04, 0.0);
  scene.objects.push_back({"first", Box(0.05F, 0.03F, 0.12F), first});
  scene.objects.push_back({"second", Box(0.04F, 0.06F, 0.08F), second});
  return scene;
}

TEST(SceneRenderer, EqualsBruteForceRays) {
  const SimScene scene = TwoBoxes();
  const CameraModel camera;
  SceneRenderer renderer(scene, camera);
  Rng rng(7);
  int wrong = 0;
  std::array<int, 5> seen{};
  for (int view = 0; view < 4; ++view) {
    const Pose T_world_camera =
        LookAt({rng.Uniform(-0.6, 0.6), -0.5, rng.Uniform(0.25, 0.7)}, {0.0, 0.0, 0.05});
    const RenderedView& rendered = renderer.Render(T_world_camera);
    const Pose T_camera_world = T_world_camera.inverse();
    for (int i = 0; i < 500; ++i) {
      const int u = static_cast<int>(rng.Below(640));
      const int v = static_cast<int>(rng.Below(480));
      const Eigen::Vector3d ray = camera.Unproject(u, v, 1.0);
      Hit hit;
      for (uint32_t j = 0; j < 2; ++j) {
        CastRay(
            scene.objects[j].mesh, T_camera_world * scene.objects[j].T_world_object, ray, j, &hit);
      }
      CastRay(PlaneAt(0.0, 0.4), T_camera_world, ray, renderer.Table(), &hit);
      CastRay(PlaneAt(-0.7, 2.0), T_camera_world, ray, renderer.Floor(), &hit);
      const size_t pixel = rendered.depth.Index(u, v);
      ++seen[hit.surface == RenderedView::kNoSurface ? 4 : hit.surface];
      if (rendered.surface[pixel] != hit.surface) {
        ++wrong;  // On an edge rounding may decide otherwise.
        continue;
      }
      if (hit.surface == RenderedView::kNoSurface) {
        EXPECT_TRUE(std::isnan(rendered.depth.depth[pixel]));
        continue;
      }
      EXPECT_NEAR(static_cast<double>(rendered.depth.depth[pixel]), hit.depth, 2e-5);
      // The sides of a box meet the same ray at different angles; edges again.
      if (std::abs(static_cast<double>(rendered.cos_incidence[pixel]) - hit.cosine) > 1e-3) ++wrong;
    }
  }
  EXPECT_LE(wrong, 4);
  for (const int count : {seen[0], seen[1], seen[2], seen[3]}) EXPECT_GT(count, 10);
}

TEST(SceneRenderer, EmptySceneHasNoDepth) {
  SceneRenderer renderer(SimScene{}, CameraModel{});
  const RenderedView& view = renderer.Render(LookAt({0.0, -1.0, 1.0}, {0.0, 0.0, 0.0}));
  for (const float z : view.depth.depth) ASSERT_TRUE(std::isnan(z));
}

TEST(SceneRenderer, SecondRenderForgetsTheFirst) {
  const SimScene scene = TwoBoxes();
  SceneRenderer renderer(scene, CameraModel{});
  const Pose pose = LookAt({0.1, -0.5, 0.5}, {0.0, 0.0, 0.05});
  const DepthImage first = renderer.Render(pose).depth;
  renderer.Render(LookAt({-0.4, 0.5, 0.3}, {0.0, 0.0, 0.05}));
  const DepthImage& again = renderer.Render(pose).depth;
  for (size_t i = 0; i < first.depth.size(); ++i) {
    if (std::isnan(first.depth[i])) {
      ASSERT_TRUE(std::isnan(again.depth[i]));
    } else {
      ASSERT_EQ(first.depth[i], again.depth[i]);
    }
  }
}

TEST(SimPlane, ValidateNamesTheBound) {
  EXPECT_TRUE(SimPlane{}.Validate().ok());
  const Result<void> flat = SimPlane{.size = {0.0, 1.0}}.Validate();
  ASSERT_FALSE(flat.ok());
  EXPECT_NE(flat.error().message.find("expected 0.01"), std::string::npos);
  EXPECT_FALSE(SimPlane{.height = std::nan("")}.Validate().ok());
}

}  // namespace
}  // namespace vantage
