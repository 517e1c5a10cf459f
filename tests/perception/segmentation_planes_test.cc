// Several planes, the image's border, and images that make no sense.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <set>

#include "perception/segmentation/segmentation.h"
#include "tests/perception/test_scenes.h"

namespace vantage {
namespace {

const CameraModel kCamera = SmallCamera();

Pose At(double x, double y, double z) { return Pose(Eigen::Translation3d(x, y, z)); }

// A wall of 1.2 m behind the table's far edge; of its points the camera sees the front.
TriangleMesh MakeWall() {
  TriangleMesh mesh;
  mesh.vertices = {
      {0.0F, -0.6F, 0.0F}, {0.0F, 0.6F, 0.0F}, {0.0F, 0.6F, 0.8F}, {0.0F, -0.6F, 0.8F}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

struct Scene {
  explicit Scene(const Eigen::Vector3d& eye, const Eigen::Vector3d& target)
      : T_world_camera(LookAt(eye, target)), rasterizer(kCamera) {}
  void Draw(const TriangleMesh& mesh, const Pose& T_world_mesh, uint32_t id) {
    rasterizer.Draw(mesh, T_world_camera.inverse() * T_world_mesh, id);
  }
  [[nodiscard]] DepthImage Measure() const {
    DepthImage depth = ToImage(rasterizer);
    Rng rng(1);
    AddNoise(kCamera.fx, 0.0014, 0.125, rng, &depth);
    return depth;
  }
  Pose T_world_camera;
  DepthRasterizer rasterizer;
};

TEST(SegmentationPlanes, WallIsNeitherSupportNorObject) {
  Scene scene({0.7, 0.0, 0.5}, {0.0, 0.0, 0.1});
  scene.Draw(MakeTable(0.8F), At(0.0, 0.0, 0.0), 0);
  scene.Draw(MakeWall(), At(-0.38, 0.0, 0.0), 1);
  scene.Draw(MakeBox({-0.03F, -0.03F, 0.0F}, {0.03F, 0.03F, 0.06F}), At(0.1, 0.0, 0.0), 2);
  Rng rng(1);
  const Segmentation result = Segment(scene.Measure(), kCamera, {}, rng);
  ASSERT_EQ(result.planes.size(), 2U);
  EXPECT_TRUE(result.planes[0].carries);
  EXPECT_FALSE(result.planes[1].carries);
  EXPECT_NEAR(result.planes[0].normal.dot(result.planes[1].normal), 0.0, 0.02);
  ASSERT_EQ(result.clusters.size(), 1U);
  for (const uint32_t pixel : result.clusters[0].pixels) {
    EXPECT_EQ(scene.rasterizer.mesh_ids()[pixel], 2U);
  }
}

TEST(SegmentationPlanes, ObjectsStandOnEachOfTwoTables) {
  Scene scene({0.8, 0.0, 0.9}, {0.0, 0.0, 0.1});
  const TriangleMesh box = MakeBox({-0.04F, -0.04F, 0.0F}, {0.04F, 0.04F, 0.08F});
  scene.Draw(MakeTable(0.6F), At(0.0, -0.32, 0.0), 0);
  scene.Draw(MakeTable(0.6F), At(0.0, 0.32, 0.15), 1);
  scene.Draw(box, At(0.0, -0.25, 0.0), 2);
  scene.Draw(box, At(0.0, 0.25, 0.15), 3);
  Rng rng(1);
  const Segmentation result = Segment(scene.Measure(), kCamera, {}, rng);
  ASSERT_EQ(result.planes.size(), 2U);
  EXPECT_TRUE(result.planes[1].carries);
  ASSERT_EQ(result.clusters.size(), 2U);
  const auto id = [&](size_t i) {
    return scene.rasterizer
        .mesh_ids()[result.clusters[i].pixels[result.clusters[i].pixels.size() / 2]];
  };
  EXPECT_EQ(std::min(id(0), id(1)), 2U);
  EXPECT_EQ(std::max(id(0), id(1)), 3U);
}

// The mesh that most of a cluster's pixels show.
uint32_t MeshOf(const Scene& scene, const Cluster& cluster) {
  std::array<size_t, 32> counts{};
  for (const uint32_t pixel : cluster.pixels) ++counts.at(scene.rasterizer.mesh_ids()[pixel]);
  return static_cast<uint32_t>(std::max_element(counts.begin(), counts.end()) - counts.begin());
}

std::set<uint32_t> MeshesOfWholes(const Scene& scene, const Segmentation& result) {
  std::set<uint32_t> meshes;
  for (const Cluster& cluster : result.clusters) {
    if (cluster.parent >= 0) continue;
    EXPECT_TRUE(meshes.insert(MeshOf(scene, cluster)).second);
  }
  return meshes;
}

TEST(SegmentationPlanes, FlatTopsAtOneHeightAreNone) {
  // Their tops are on one plane, of large extent and of most points that are not the table's.
  for (int view = 0; view < 12; ++view) {
    const double azimuth = 0.5 * view;
    const double elevation = (30.0 + 10.0 * (view % 4)) * kDegree;
    Scene scene({0.7 * std::cos(elevation) * std::cos(azimuth),
                 0.7 * std::cos(elevation) * std::sin(azimuth),
                 0.7 * std::sin(elevation)},
                {0.0, 0.0, 0.0});
    scene.Draw(MakeTable(0.7F), At(0.0, 0.0, 0.0), 0);
    std::set<uint32_t> boxes;
    for (int i = 0; i < 6; ++i) {
      const auto id = static_cast<uint32_t>(i + 1);
      scene.Draw(MakeBox({-0.05F, -0.05F, 0.0F}, {0.05F, 0.05F, 0.05F}),
                 At(0.16 * (i % 3 - 1), 0.18 * (i / 3) - 0.09, 0.0),
                 id);
      boxes.insert(id);
    }
    Rng rng(1);
    const Segmentation result = Segment(scene.Measure(), kCamera, {}, rng);
    EXPECT_EQ(result.planes.size(), 1U) << view;
    EXPECT_EQ(MeshesOfWholes(scene, result), boxes) << view;
  }
}

TEST(SegmentationPlanes, BoardOverTableIsOneBesideObjectsOfItsHeight) {
  Scene scene({0.9, 0.1, 0.8}, {0.0, 0.0, 0.1});
  scene.Draw(MakeTable(0.8F), At(0.0, 0.0, 0.0), 0);
  scene.Draw(MakeBox({-0.15F, -0.35F, -0.02F}, {0.15F, 0.35F, 0.0F}), At(-0.3, 0.0, 0.2), 1);
  const TriangleMesh box = MakeBox({-0.04F, -0.04F, 0.0F}, {0.04F, 0.04F, 0.08F});
  scene.Draw(box, At(0.15, -0.2, 0.0), 2);
  scene.Draw(box, At(0.15, 0.2, 0.0), 3);
  scene.Draw(box, At(-0.3, 0.1, 0.2), 4);
  // Tall ones, of which one hides some of the board.
  scene.Draw(MakeBox({-0.03F, -0.03F, 0.0F}, {0.03F, 0.03F, 0.2F}), At(0.2, 0.03, 0.0), 5);
  Rng rng(1);
  const Segmentation result = Segment(scene.Measure(), kCamera, {}, rng);
  ASSERT_EQ(result.planes.size(), 2U);
  EXPECT_TRUE(result.planes[1].carries);
  EXPECT_NEAR(result.planes[1].offset - result.planes[0].offset, 0.2, 0.01);
  const std::set<uint32_t> meshes = MeshesOfWholes(scene, result);
  for (const uint32_t object : {2U, 3U, 4U, 5U}) EXPECT_TRUE(meshes.contains(object)) << object;
}

TEST(SegmentationPlanes, WallIsFoundAroundWhatHidesIt) {
  Scene scene({0.8, 0.0, 0.35}, {0.0, 0.0, 0.15});
  scene.Draw(MakeTable(0.8F), At(0.0, 0.0, 0.0), 0);
  scene.Draw(MakeWall(), At(-0.38, 0.0, 0.0), 1);
  scene.Draw(MakeBox({-0.03F, -0.03F, 0.0F}, {0.03F, 0.03F, 0.3F}), At(-0.1, 0.0, 0.0), 2);
  scene.Draw(MakeBox({-0.03F, -0.03F, 0.0F}, {0.03F, 0.03F, 0.05F}), At(0.1, 0.15, 0.0), 3);
  Rng rng(1);
  const Segmentation result = Segment(scene.Measure(), kCamera, {}, rng);
  ASSERT_EQ(result.planes.size(), 2U);
  EXPECT_EQ(MeshesOfWholes(scene, result), (std::set<uint32_t>{2, 3}));
}

TEST(SegmentationPlanes, WallLargerThanTheTableCarriesNothing) {
  Scene scene({0.9, 0.0, 0.3}, {0.0, 0.0, 0.2});
  scene.Draw(MakeTable(0.6F), At(0.0, 0.0, 0.0), 0);
  scene.Draw(MakeWall(), At(-0.3, 0.0, 0.0), 1);
  scene.Draw(MakeBox({-0.04F, -0.04F, 0.0F}, {0.04F, 0.04F, 0.08F}), At(0.0, -0.1, 0.0), 2);
  scene.Draw(MakeBox({-0.04F, -0.04F, 0.0F}, {0.04F, 0.04F, 0.08F}), At(0.0, 0.1, 0.0), 3);
  Rng rng(1);
  const Segmentation result = Segment(scene.Measure(), kCamera, {}, rng);
  ASSERT_EQ(result.planes.size(), 2U);
  EXPECT_FALSE(result.planes[0].carries);  // The one of most points is the wall.
  EXPECT_TRUE(result.planes[1].carries);
  EXPECT_EQ(MeshesOfWholes(scene, result), (std::set<uint32_t>{2, 3}));
}

TEST(SegmentationPlanes, PlanesAloneHaveNoObjects) {
  Scene scene({0.7, 0.0, 0.5}, {0.0, 0.0, 0.1});
  scene.Draw(MakeTable(0.8F), At(0.0, 0.0, 0.0), 0);
  scene.Draw(MakeWall(), At(-0.38, 0.0, 0.0), 1);
  scene.Draw(MakeTable(6.0F), At(0.0, 0.0, -0.7), 2);
  Rng rng(1);
  EXPECT_TRUE(Segment(scene.Measure(), kCamera, {}, rng).clusters.empty());
}

// A square of 30 px at 0.7 m whose left side is at column u.
bool TouchesBorder(int u, float beside) {
  SegmentationParameters parameters;
  parameters.support = SegmentationParameters::Support::kNone;
  DepthImage depth(kCamera.width, kCamera.height);
  for (int v = 100; v < 130; ++v) {
    for (int i = 0; i < u; ++i) depth.at(i, v) = beside;
    for (int i = 0; i < 30; ++i) depth.at(u + i, v) = 0.7F;
  }
  Rng rng(1);
  const Segmentation result = Segment(depth, kCamera, parameters, rng);
  // Turned by a half and by a quarter it is the same.
  DepthImage turned = depth;
  std::reverse(turned.depth.begin(), turned.depth.end());
  EXPECT_EQ(Segment(turned, kCamera, parameters, rng).clusters[0].touches_border,
            result.clusters[0].touches_border);
  CameraModel tall = kCamera;
  std::swap(tall.width, tall.height);
  DepthImage lying(tall.width, tall.height);
  for (int v = 0; v < lying.height; ++v) {
    for (int i = 0; i < lying.width; ++i) lying.at(i, v) = depth.at(v, i);
  }
  EXPECT_EQ(Segment(lying, tall, parameters, rng).clusters[0].touches_border,
            result.clusters[0].touches_border);
  EXPECT_EQ(result.clusters.size(), 1U);
  return result.clusters[0].touches_border;
}

TEST(SegmentationBorder, IsReachedWithinPixelsAndOverMissingData) {
  EXPECT_TRUE(TouchesBorder(0, DepthImage::kInvalid));
  EXPECT_TRUE(TouchesBorder(2, 5.0F));
  EXPECT_FALSE(TouchesBorder(3, 5.0F));  // Background is measured beside it.
  EXPECT_TRUE(TouchesBorder(8, DepthImage::kInvalid));
  EXPECT_TRUE(TouchesBorder(8, 0.0F));
  EXPECT_TRUE(TouchesBorder(8, std::numeric_limits<float>::infinity()));
  EXPECT_FALSE(TouchesBorder(8, 5.0F));
  EXPECT_FALSE(TouchesBorder(16, DepthImage::kInvalid));
}

TEST(SegmentationInput, MayBeAnything) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  for (const auto& [width, height] :
       {std::pair{1, 1}, {2, 2}, {1, 40}, {40, 1}, {33, 17}, {320, 240}}) {
    CameraModel camera = kCamera;
    camera.width = width;
    camera.height = height;
    for (const float z :
         {DepthImage::kInvalid, kInfinity, -kInfinity, 0.0F, -1.0F, 1e-38F, 65.535F, 0.7F}) {
      for (const auto support :
           {SegmentationParameters::Support::kAuto, SegmentationParameters::Support::kNone}) {
        SegmentationParameters parameters;
        parameters.support = support;
        parameters.min_points = 1;
        Rng rng(1);
        DepthImage depth(width, height, z);
        Segment(depth, camera, parameters, rng);
        for (float& value : depth.depth) {
          const std::array<float, 6> values = {
              z, DepthImage::kInvalid, kInfinity, 0.3F, 1.0F, 2.9F};
          value = values[rng.Below(6)];
        }
        const Segmentation result = Segment(depth, camera, parameters, rng);
        for (const Cluster& cluster : result.clusters) {
          for (const uint32_t pixel : cluster.pixels) {
            EXPECT_TRUE(depth.depth[pixel] >= 0.2F && depth.depth[pixel] <= 3.0F);
          }
        }
      }
    }
  }
}

TEST(SegmentationInput, CameraMustBeValid) {
  CameraModel camera = kCamera;
  camera.fx = 0.0;
  Rng rng(1);
  EXPECT_DEATH(Segment(DepthImage(320, 240), camera, {}, rng), "camera");
}

}  // namespace
}  // namespace vantage
