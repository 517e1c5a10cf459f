// What touches is divided, what is one object stays whole as well: views of the simulated sensor.
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "drivers/sim/scene_renderer.h"
#include "drivers/sim/sensor_model.h"
#include "perception/model/model_generator.h"
#include "perception/segmentation/segmentation.h"
#include "tests/bus/fuzz/count_allocations.h"
#include "tests/perception/test_scenes.h"

namespace vantage {
namespace {

struct View {
  CameraModel camera;
  DepthImage depth;
  std::vector<uint32_t> objects;  // Of each pixel; others than 0, 1 ... for no object.
};

View MakeView(std::vector<SimObject> objects, double azimuth, double elevation, uint64_t device) {
  SimScene scene;
  scene.table = SimPlane{};
  scene.objects = std::move(objects);
  View view;
  SceneRenderer renderer(scene, view.camera);
  SensorModelParameters parameters;
  parameters.device_id = device;
  SensorModel sensor(parameters, view.camera);
  const Eigen::Vector3d direction(std::cos(elevation) * std::cos(azimuth),
                                  std::cos(elevation) * std::sin(azimuth),
                                  std::sin(elevation));
  const RenderedView& rendered =
      renderer.Render(LookAt(0.75 * direction, Eigen::Vector3d(0.0, 0.0, 0.04)));
  sensor.Measure(rendered, 0, 0.0, &view.depth);
  view.objects = rendered.surface;
  return view;
}

Pose At(double x, double y, double z, double yaw = 0.0) {
  return Pose(Eigen::Translation3d(x, y, z) * Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()));
}

TriangleMesh Box(float width, float depth, float height) {
  return MakeBox({-0.5F * width, -0.5F * depth, 0.0F}, {0.5F * width, 0.5F * depth, height});
}

TriangleMesh Sphere(float radius) {
  constexpr uint32_t kAround = 40;
  constexpr uint32_t kDown = 20;
  TriangleMesh mesh;
  for (uint32_t j = 0; j <= kDown; ++j) {
    for (uint32_t i = 0; i < kAround; ++i) {
      const float t = std::numbers::pi_v<float> * static_cast<float>(j) / kDown;
      const float p = 2.0F * std::numbers::pi_v<float> * static_cast<float>(i) / kAround;
      mesh.vertices.emplace_back(radius * std::sin(t) * std::cos(p),
                                 radius * std::sin(t) * std::sin(p),
                                 radius * (1.0F + std::cos(t)));
    }
  }
  for (uint32_t j = 0; j < kDown; ++j) {
    for (uint32_t i = 0; i < kAround; ++i) {
      const uint32_t a = j * kAround + i;
      const uint32_t b = j * kAround + (i + 1) % kAround;
      mesh.triangles.push_back({a, a + kAround, b});
      mesh.triangles.push_back({b, a + kAround, b + kAround});
    }
  }
  return mesh;
}

TriangleMesh Generated(const std::string& name) { return GenerateObject(name).value().mesh; }

// Two meshes that nearly touch, one on either side of y = 0.
std::vector<SimObject> SideBySide(const TriangleMesh& left, const TriangleMesh& right) {
  const auto reach = static_cast<double>(left.Bounds().max().y());
  const auto begin = static_cast<double>(right.Bounds().min().y());
  return {{"left", left, At(0.0, -reach - 5e-4, 0.0)},
          {"right", right, At(0.0, 5e-4 - begin, 0.0)}};
}

// Largest share of an object that one segment shows, of those that show hardly anything else.
double BestPureShare(const View& view, const Segmentation& segmentation, uint32_t object) {
  const auto whole = std::count(view.objects.begin(), view.objects.end(), object);
  double best = 0.0;
  for (const Cluster& cluster : segmentation.clusters) {
    const auto own = std::count_if(cluster.pixels.begin(),
                                   cluster.pixels.end(),
                                   [&](uint32_t pixel) { return view.objects[pixel] == object; });
    if (static_cast<double>(own) < 0.9 * static_cast<double>(cluster.pixels.size())) continue;
    best = std::max(best, static_cast<double>(own) / static_cast<double>(whole));
  }
  return best;
}

// Views of 8 directions in which both objects have a segment of their own.
int ViewsThatPart(const std::vector<SimObject>& objects) {
  int parted = 0;
  for (int i = 0; i < 8; ++i) {
    const View view = MakeView(objects,
                               i * std::numbers::pi / 4.0 + 0.2,
                               (30 + 5 * (i % 4)) * kDegree,
                               static_cast<uint64_t>(i));
    Rng rng(1);
    const Segmentation result = Segment(view.depth, view.camera, {}, rng);
    const double worst = std::min(BestPureShare(view, result, 0), BestPureShare(view, result, 1));
    parted += worst > 0.35 ? 1 : 0;
  }
  return parted;
}

TEST(SegmentationParts, BoxOnBox) {
  EXPECT_GE(ViewsThatPart({{"low", Box(0.14F, 0.14F, 0.06F), At(0.0, 0.0, 0.0)},
                           {"high", Box(0.06F, 0.06F, 0.06F), At(0.0, 0.0, 0.0605)}}),
            7);
}

TEST(SegmentationParts, BoxesSideBySide) {
  // From where their faces are flush there is nothing to tell them by.
  EXPECT_GE(ViewsThatPart(SideBySide(Box(0.06F, 0.06F, 0.09F), Box(0.12F, 0.06F, 0.04F))), 5);
}

TEST(SegmentationParts, SphereAtBox) {
  EXPECT_GE(ViewsThatPart(SideBySide(Sphere(0.04F), Box(0.08F, 0.08F, 0.07F))), 6);
}

TEST(SegmentationParts, TheSameModelTwice) {
  EXPECT_GE(ViewsThatPart(SideBySide(Generated("mug"), Generated("mug"))), 5);
  EXPECT_GE(ViewsThatPart(SideBySide(Generated("filter"), Generated("filter"))), 7);
}

TEST(SegmentationParts, ObjectsStayWholeAndHaveFewParts) {
  for (const std::string& name : GeneratedObjectNames()) {
    const View view =
        MakeView({{name, Generated(name), At(0.0, 0.0, 0.0)}}, 0.4, 40.0 * kDegree, 3);
    Rng rng(1);
    const Segmentation result = Segment(view.depth, view.camera, {}, rng);
    ASSERT_FALSE(result.clusters.empty()) << name;
    const auto seen = std::count(view.objects.begin(), view.objects.end(), 0U);
    EXPECT_EQ(result.clusters[0].parent, -1) << name;
    EXPECT_GT(static_cast<double>(result.clusters[0].pixels.size()),
              0.6 * static_cast<double>(seen))
        << name;
    const auto parts = std::count_if(result.clusters.begin(),
                                     result.clusters.end(),
                                     [](const Cluster& cluster) { return cluster.parent == 0; });
    EXPECT_LE(parts, 6) << name;
  }
}

TEST(SegmentationParts, ConvexBodiesHaveNone) {
  for (const TriangleMesh& mesh : {Box(0.10F, 0.07F, 0.08F), Sphere(0.05F)}) {
    for (uint64_t i = 0; i < 6; ++i) {
      const View view =
          MakeView({{"convex", mesh, At(0.0, 0.0, 0.0)}}, 0.7 * static_cast<double>(i), 0.7, i);
      Rng rng(1);
      EXPECT_EQ(Segment(view.depth, view.camera, {}, rng).clusters.size(), 1U);
    }
  }
}

TEST(SegmentationParts, ShareOutTheirCluster) {
  const View view = MakeView(SideBySide(Generated("mug"), Generated("filter")), 0.3, 0.6, 1);
  Rng rng(1);
  const Segmentation result = Segment(view.depth, view.camera, {}, rng);
  size_t parts = 0;
  for (size_t i = 0; i < result.clusters.size(); ++i) {
    const Cluster& whole = result.clusters[i];
    if (whole.parent >= 0) continue;
    std::vector<uint32_t> shared;
    int32_t label = whole.first_label;
    for (size_t j = i + 1; j < result.clusters.size() && result.clusters[j].parent >= 0; ++j) {
      const Cluster& part = result.clusters[j];
      EXPECT_EQ(part.parent, static_cast<int>(i));
      EXPECT_EQ(part.first_label, label);
      EXPECT_EQ(part.last_label, label++);
      for (const uint32_t pixel : part.pixels) EXPECT_EQ(result.labels[pixel], part.first_label);
      EXPECT_GE(part.pixels.size(), 100U);
      shared.insert(shared.end(), part.pixels.begin(), part.pixels.end());
      ++parts;
    }
    if (shared.empty()) {
      EXPECT_EQ(whole.first_label, whole.last_label);
      continue;
    }
    EXPECT_EQ(whole.last_label, label - 1);
    std::sort(shared.begin(), shared.end());
    EXPECT_EQ(shared, whole.pixels);
  }
  EXPECT_GE(parts, 2U);
}

TEST(Segmenter, AllocatesNothingOnceWarmAndRepeatsItself) {
  const View one = MakeView(SideBySide(Generated("mug"), Generated("mug")), 0.3, 0.6, 1);
  const View other = MakeView({{"filter", Generated("filter"), At(0.0, 0.0, 0.0)}}, 1.3, 0.8, 2);
  Segmenter segmenter({});
  std::vector<int32_t> labels;
  // Buffers for pixels change places between the two until each is large enough.
  for (int i = 0; i < 12; ++i) {
    Rng rng(1);
    labels = segmenter.Segment(i % 2 == 0 ? one.depth : other.depth, one.camera, rng).labels;
  }
  const size_t before = BytesAllocated();
  for (int i = 0; i < 4; ++i) {
    Rng rng(1);
    const Segmentation& result =
        segmenter.Segment(i % 2 == 0 ? one.depth : other.depth, one.camera, rng);
    EXPECT_TRUE(i % 2 == 0 || result.labels == labels);
  }
  EXPECT_EQ(BytesAllocated(), before);
}

}  // namespace
}  // namespace vantage
