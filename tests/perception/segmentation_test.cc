#include "perception/segmentation/segmentation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <queue>
#include <set>

#include "tests/perception/test_scenes.h"

namespace vantage {
namespace {

const CameraModel kCamera = SmallCamera();

struct TableScene {
  Pose T_world_camera = LookAt({0.5, 0.0, 0.6}, {0.0, 0.0, 0.0});
  DepthImage depth;
  std::vector<uint32_t> ids;
};

// Two boxes on a table over a floor far below.
TableScene MakeScene() {
  TableScene scene;
  const Pose T_camera_world = scene.T_world_camera.inverse();
  DepthRasterizer rasterizer(kCamera);
  const TriangleMesh box = MakeBox({-0.03F, -0.03F, 0.0F}, {0.03F, 0.03F, 0.06F});
  rasterizer.Draw(MakeTable(0.7F), T_camera_world, 0);
  rasterizer.Draw(box, T_camera_world * Eigen::Translation3d(0.0, -0.15, 0.0), 1);
  rasterizer.Draw(box, T_camera_world * Eigen::Translation3d(0.0, 0.12, 0.0), 2);
  rasterizer.Draw(MakeTable(6.0F), T_camera_world * Eigen::Translation3d(0.0, 0.0, -0.7), 3);
  scene.depth = ToImage(rasterizer);
  scene.ids.assign(rasterizer.mesh_ids().begin(), rasterizer.mesh_ids().end());
  return scene;
}

TEST(Segmentation, FindsObjectsOnTableAndNothingElse) {
  TableScene scene = MakeScene();
  Rng rng(1);
  AddNoise(kCamera.fx, 0.0014, 0.125, rng, &scene.depth);
  const Segmentation result = Segment(scene.depth, kCamera, {}, rng);
  ASSERT_EQ(result.planes.size(), 2U);  // The floor is one too.
  const Eigen::Vector3d up = scene.T_world_camera.linear().transpose() * Eigen::Vector3d::UnitZ();
  EXPECT_LT(std::acos(std::min(1.0, result.planes[0].normal.dot(up))), 0.3 * kDegree);
  EXPECT_NEAR(result.planes[0].offset, -0.6, 0.002);
  ASSERT_EQ(result.clusters.size(), 2U);
  std::set<uint32_t> objects;
  for (const Cluster& cluster : result.clusters) {
    EXPECT_FALSE(cluster.touches_border);
    std::array<size_t, 4> count{};
    for (const uint32_t pixel : cluster.pixels) ++count[scene.ids[pixel]];
    const auto most = std::max_element(count.begin(), count.end()) - count.begin();
    objects.insert(static_cast<uint32_t>(most));
    EXPECT_GT(count[static_cast<size_t>(most)], 0.97 * static_cast<double>(cluster.pixels.size()));
    // But for the lowest millimetres the whole object is there.
    const auto whole = std::count(scene.ids.begin(), scene.ids.end(), most);
    EXPECT_GT(static_cast<double>(cluster.pixels.size()), 0.85 * static_cast<double>(whole));
  }
  EXPECT_EQ(objects, (std::set<uint32_t>{1, 2}));
}

TEST(Segmentation, LabelsAgreeWithClusters) {
  TableScene scene = MakeScene();
  Rng rng(1);
  const Segmentation result = Segment(scene.depth, kCamera, {}, rng);
  for (size_t i = 0; i < result.clusters.size(); ++i) {
    const Cluster& cluster = result.clusters[i];
    EXPECT_TRUE(std::is_sorted(cluster.pixels.begin(), cluster.pixels.end()));
    PixelWindow window{kCamera.width, kCamera.height, -1, -1};
    for (const uint32_t pixel : cluster.pixels) {
      EXPECT_TRUE(cluster.Holds(result.labels[pixel]));
      window.u0 = std::min(window.u0, static_cast<int>(pixel) % kCamera.width);
      window.u1 = std::max(window.u1, static_cast<int>(pixel) % kCamera.width);
      window.v0 = std::min(window.v0, static_cast<int>(pixel) / kCamera.width);
      window.v1 = std::max(window.v1, static_cast<int>(pixel) / kCamera.width);
    }
    EXPECT_EQ(window.u0, cluster.window.u0);
    EXPECT_EQ(window.u1, cluster.window.u1);
    EXPECT_EQ(window.v0, cluster.window.v0);
    EXPECT_EQ(window.v1, cluster.window.v1);
    const auto held = std::count_if(result.labels.begin(), result.labels.end(), [&](int32_t label) {
      return cluster.Holds(label);
    });
    EXPECT_EQ(static_cast<size_t>(held), cluster.pixels.size());
  }
}

TEST(Segmentation, IsTheSameForTheSameSeed) {
  TableScene scene = MakeScene();
  Rng a(5);
  Rng b(5);
  EXPECT_EQ(Segment(scene.depth, kCamera, {}, a).labels,
            Segment(scene.depth, kCamera, {}, b).labels);
}

TEST(Segmentation, FacesOfAnObjectAloneAreNoSupport) {
  const Pose T_camera_box =
      LookAt({0.3, 0.2, 0.3}, {0.0, 0.0, 0.0}).inverse() * Eigen::Translation3d(0.0, 0.0, 0.0);
  DepthRasterizer rasterizer(kCamera);
  rasterizer.Draw(MakeBox({-0.08F, -0.08F, -0.08F}, {0.08F, 0.08F, 0.08F}), T_camera_box);
  const DepthImage depth = ToImage(rasterizer);
  Rng rng(1);
  const Segmentation result = Segment(depth, kCamera, {}, rng);
  EXPECT_TRUE(result.planes.empty());
  ASSERT_EQ(result.clusters.size(), 1U);
  const auto valid =
      std::count_if(depth.depth.begin(), depth.depth.end(), [](float z) { return z > 0.0F; });
  EXPECT_EQ(static_cast<std::ptrdiff_t>(result.clusters[0].pixels.size()), valid);
}

TEST(Segmentation, NothingComesOfNothing) {
  Rng rng(1);
  EXPECT_TRUE(Segment(DepthImage(320, 240), kCamera, {}, rng).clusters.empty());
  DepthImage point(320, 240);
  point.at(100, 100) = 0.7F;
  EXPECT_TRUE(Segment(point, kCamera, {}, rng).clusters.empty());
  // A wall straight ahead is a plane, and nothing is on it.
  EXPECT_TRUE(Segment(DepthImage(320, 240, 0.8F), kCamera, {}, rng).clusters.empty());
  for (const float strange : {0.0F, -1.0F, 1e-30F, 1e30F, std::numeric_limits<float>::infinity()}) {
    EXPECT_TRUE(Segment(DepthImage(320, 240, strange), kCamera, {}, rng).clusters.empty());
  }
}

TEST(Segmentation, MarksClustersAtTheBorder) {
  SegmentationParameters parameters;
  parameters.support = SegmentationParameters::Support::kNone;
  parameters.min_points = 10;
  DepthImage depth(320, 240);
  for (int v = 50; v < 60; ++v) {
    for (int u = 0; u < 10; ++u) depth.at(u, v) = 0.7F;
    for (int u = 100; u < 111; ++u) depth.at(u, v) = 0.7F;
  }
  Rng rng(1);
  const Segmentation result = Segment(depth, kCamera, parameters, rng);
  ASSERT_EQ(result.clusters.size(), 2U);
  EXPECT_FALSE(result.clusters[0].touches_border);
  EXPECT_TRUE(result.clusters[1].touches_border);
}

// Flood fill by the definition: neighbors, and over missing data along rows and columns.
std::set<std::vector<uint32_t>> BruteForceClusters(const DepthImage& depth,
                                                   const CameraModel& camera,
                                                   const SegmentationParameters& parameters) {
  const int reach = parameters.gap_px + 1;
  std::vector<bool> seen(depth.depth.size(), false);
  std::set<std::vector<uint32_t>> clusters;
  for (int v0 = 0; v0 < depth.height; ++v0) {
    for (int u0 = 0; u0 < depth.width; ++u0) {
      if (seen[depth.Index(u0, v0)] || std::isnan(depth.at(u0, v0))) continue;
      std::vector<uint32_t> pixels;
      std::queue<std::pair<int, int>> open;
      open.emplace(u0, v0);
      seen[depth.Index(u0, v0)] = true;
      while (!open.empty()) {
        const auto [u, v] = open.front();
        open.pop();
        pixels.push_back(static_cast<uint32_t>(depth.Index(u, v)));
        for (int dv = -reach; dv <= reach; ++dv) {
          for (int du = -reach; du <= reach; ++du) {
            const bool adjacent = std::max(std::abs(du), std::abs(dv)) == 1;
            if (!adjacent && du != 0 && dv != 0) continue;
            if (!depth.Contains(u + du, v + dv) || seen[depth.Index(u + du, v + dv)]) continue;
            const double z = static_cast<double>(depth.at(u, v));
            const double other = static_cast<double>(depth.at(u + du, v + dv));
            if (std::isnan(other)) continue;
            const double far = std::max(z, other);
            const double limit =
                parameters.largest_gap + 2.0 / camera.fx * far * std::hypot(du, dv);
            if (std::abs(z - other) > limit) continue;
            seen[depth.Index(u + du, v + dv)] = true;
            open.emplace(u + du, v + dv);
          }
        }
      }
      std::sort(pixels.begin(), pixels.end());
      if (pixels.size() >= static_cast<size_t>(parameters.min_points)) clusters.insert(pixels);
    }
  }
  return clusters;
}

TEST(Segmentation, ClustersEqualFloodFill) {
  CameraModel camera = SmallCamera();
  camera.width = 24;
  camera.height = 18;
  SegmentationParameters parameters;
  parameters.support = SegmentationParameters::Support::kNone;
  parameters.min_points = 2;
  parameters.concave_angle_deg = 180.0;  // Whole clusters alone.
  Rng rng(3);
  size_t several = 0;
  for (int trial = 0; trial < 200; ++trial) {
    parameters.gap_px = trial % 3;
    const double filled = rng.Uniform(0.05, 0.9);
    DepthImage depth(camera.width, camera.height);
    for (float& z : depth.depth) {
      // Depths on levels far apart: no pair is near the limit, which depends on the order of z.
      if (rng.Uniform() < filled) z = 0.5F + 0.1F * static_cast<float>(rng.Below(3));
    }
    const Segmentation result = Segment(depth, camera, parameters, rng);
    std::set<std::vector<uint32_t>> clusters;
    for (const Cluster& cluster : result.clusters) clusters.insert(cluster.pixels);
    EXPECT_EQ(clusters, BruteForceClusters(depth, camera, parameters)) << trial;
    several += clusters.size() > 1 ? 1U : 0U;
  }
  EXPECT_GT(several, 100U);
}

TEST(SupportPlane, HullHoldsAllPointsAndIsConvex) {
  Rng rng(4);
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<Eigen::Vector2d> points;
    const uint32_t count = 3 + rng.Below(60);
    for (uint32_t i = 0; i < count; ++i) {
      // A coarse lattice gives duplicates and collinear points.
      points.emplace_back(0.1 * rng.Below(8), 0.1 * rng.Below(8));
    }
    std::vector<Eigen::Vector2d> hull = points;
    std::vector<Eigen::Vector2d> buffer;
    ConvexHull(&hull, &buffer);
    if (hull.size() < 3) continue;
    SupportPlane plane;
    plane.hull = hull;
    for (const Eigen::Vector2d& point : points) {
      EXPECT_TRUE(plane.IsAboveHull({point.x(), point.y(), 1.0}, 1e-9));
    }
    for (size_t i = 0; i < hull.size(); ++i) {
      const Eigen::Vector2d a = hull[(i + 1) % hull.size()] - hull[i];
      const Eigen::Vector2d b = hull[(i + 2) % hull.size()] - hull[(i + 1) % hull.size()];
      EXPECT_GT(a.x() * b.y() - a.y() * b.x(), 0.0);
    }
  }
}

TEST(SupportPlane, HullIsWidenedByMargin) {
  SupportPlane plane;
  plane.hull = {{0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}};
  EXPECT_TRUE(plane.IsAboveHull({0.5, 1.05, 0.0}, 0.1));
  EXPECT_FALSE(plane.IsAboveHull({0.5, 1.05, 0.0}, 0.01));
}

TEST(Segmentation, RefusesParametersOutOfRange) {
  SegmentationParameters parameters;
  EXPECT_TRUE(parameters.Validate().ok());
  parameters.max_depth = 0.1;
  EXPECT_NE(parameters.Validate().error().message.find("0.1"), std::string::npos);
  parameters = {};
  parameters.plane.min_share = 1.5;
  EXPECT_FALSE(parameters.Validate().ok());
}

}  // namespace
}  // namespace vantage
