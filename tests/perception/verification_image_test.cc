// Images made ready once for many hypotheses.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "perception/model/model_generator.h"
#include "perception/verification/mesh_decimation.h"
#include "perception/verification/verification.h"
#include "tests/bus/fuzz/count_allocations.h"
#include "tests/perception/test_scenes.h"

namespace vantage {
namespace {

const CameraModel kCamera = SmallCamera();

ModelShape ShapeOf(const DrawableMesh& mesh) {
  return {mesh, mesh.center(), 2.0 * mesh.radius(), mesh.radius()};
}

// Two objects side by side, each a cluster, before a wall; some pixels measure nothing.
struct Scene {
  DrawableMesh mesh{DecimateMesh(GenerateObject("mug").value().mesh, kFineLevel)};
  std::vector<Pose> poses;
  DepthImage depth{kCamera.width, kCamera.height, 1.3F};
  Segmentation segmentation;

  Scene() {
    Rng rng(1);
    segmentation.labels.assign(depth.depth.size(), Segmentation::kNoCluster);
    for (int object = 0; object < 2; ++object) {
      Pose T(rng.Rotation());
      T.translation() = Eigen::Vector3d(object == 0 ? -0.07 : 0.05, 0.0, 0.6 + 0.05 * object) -
                        T.linear() * mesh.center();
      poses.push_back(T);
      DepthRasterizer rasterizer(kCamera);
      rasterizer.Draw(mesh.mesh(), T);
      for (size_t i = 0; i < depth.depth.size(); ++i) {
        if (rasterizer.depth()[i] >= depth.depth[i]) continue;
        depth.depth[i] = rasterizer.depth()[i];
        segmentation.labels[i] = object;
      }
    }
    AddNoise(kCamera.fx, 0.003, 0.0, rng, &depth);
    for (size_t i = 0; i < depth.depth.size(); i += 7) {
      constexpr float kInfinity = std::numeric_limits<float>::infinity();
      depth.depth[i] = std::array{DepthImage::kInvalid, 0.0F, kInfinity, -1.0F}[i / 7 % 4];
    }
    for (int object = 0; object < 2; ++object) segmentation.clusters.push_back(MakeCluster(object));
  }
  [[nodiscard]] Cluster MakeCluster(int32_t label) const {
    Cluster cluster;
    cluster.first_label = cluster.last_label = label;
    cluster.window = {kCamera.width, kCamera.height, -1, -1};
    for (int v = 0; v < kCamera.height; ++v) {
      for (int u = 0; u < kCamera.width; ++u) {
        if (segmentation.labels[depth.Index(u, v)] != label) continue;
        cluster.pixels.push_back(static_cast<uint32_t>(depth.Index(u, v)));
        PixelWindow& window = cluster.window;
        window = {std::min(window.u0, u), std::min(window.v0, v), std::max(window.u1, u), v};
      }
    }
    return cluster;
  }
  [[nodiscard]] SegmentedImage image() const { return {depth, kCamera, segmentation}; }
  [[nodiscard]] Pose Hypothesis(size_t cluster, int trial, Rng& rng) const {
    Pose T = poses[cluster];
    T.linear() = T.linear() * ExpSo3(0.03 * trial * rng.UnitVector()).toRotationMatrix();
    T.translation() += 0.002 * trial * rng.UnitVector();
    return T;
  }
};

const Scene& TheScene() {
  static const Scene scene;
  return scene;
}

void ExpectSame(const Verification& a, const Verification& b) {
  EXPECT_EQ(a.inliers, b.inliers);
  EXPECT_EQ(a.occluded, b.occluded);
  EXPECT_EQ(a.seen_through, b.seen_through);
  EXPECT_EQ(a.in_front, b.in_front);
  EXPECT_EQ(a.missing, b.missing);
  EXPECT_EQ(a.edge, b.edge);
  EXPECT_EQ(a.unexplained, b.unexplained);
  EXPECT_EQ(a.mse, b.mse);
  EXPECT_EQ(a.cost, b.cost);
}

// The definition, pixel by pixel and in double precision.
Verification Reference(const Scene& scene, const Pose& T, size_t cluster, int step) {
  const VerificationParameters parameters;
  const Cluster& own = scene.segmentation.clusters[cluster];
  const ModelShape shape = ShapeOf(scene.mesh);
  ModelView view;
  view.Render(scene.mesh, T, kCamera, ModelWindow(kCamera, shape, T), step);
  std::vector<uint8_t> shown(scene.depth.depth.size(), 0);
  Verification result;
  double squared = 0.0;
  view.ForEachPixel([&](const ModelView::Pixel& pixel) {
    const size_t index = scene.depth.Index(pixel.u, pixel.v);
    shown[index] = 1;
    const auto measured = static_cast<double>(scene.depth.depth[index]);
    const auto rendered = static_cast<double>(pixel.depth);
    const Eigen::Vector3d ray = kCamera.Unproject(pixel.u, pixel.v, 1.0);
    const double along = static_cast<double>(pixel.plane_distance) / rendered;
    const double cosine = along / ray.norm();
    if (!(measured > 0.0) || std::isinf(measured)) {
      ++result.missing;
      result.cost += parameters.missing_cost * cosine * cosine;
      return;
    }
    const double tangent = std::min(std::sqrt(1.0 - cosine * cosine) / cosine, 5.0);
    const double lateral = parameters.noise.Lateral(rendered, kCamera.fx) * tangent;
    const double sigma =
        std::hypot(std::hypot(parameters.noise.Axial(rendered), lateral), parameters.model_error);
    const double tolerance = parameters.inlier_sigmas * sigma;
    const double error = measured - rendered;
    bool is_near = false;
    for (int dv = -parameters.edge_px; dv <= parameters.edge_px; ++dv) {
      for (int du = -parameters.edge_px; du <= parameters.edge_px; ++du) {
        if (!scene.depth.Contains(pixel.u + du, pixel.v + dv)) continue;
        const auto there = static_cast<double>(scene.depth.at(pixel.u + du, pixel.v + dv));
        is_near = is_near || std::abs(there - rendered) <= tolerance;
      }
    }
    const int32_t label = scene.segmentation.labels[index];
    if (std::abs(error) <= tolerance) {
      ++result.inliers;
      squared += error * error * along * along;
      result.cost += 0.5 * error * error / (sigma * sigma);
      if (label >= 0 && !own.Holds(label)) result.cost -= parameters.foreign_gain;
    } else if (error < 0.0 && label >= 0 && !own.Holds(label)) {
      ++result.occluded;
    } else if (is_near) {
      ++result.edge;
      result.cost += 1.0;
    } else {
      ++(error < 0.0 ? result.in_front : result.seen_through);
      result.cost += parameters.outlier_cost;
    }
  });
  const int reach = parameters.edge_px / step * step;
  for (const uint32_t index : own.pixels) {
    const int u = static_cast<int>(index) % kCamera.width;
    const int v = static_cast<int>(index) / kCamera.width;
    if (u % step != 0 || v % step != 0) continue;
    bool is_reached = false;
    for (int dv = -reach; dv <= reach; dv += step) {
      for (int du = -reach; du <= reach; du += step) {
        is_reached = is_reached || (scene.depth.Contains(u + du, v + dv) &&
                                    shown[scene.depth.Index(u + du, v + dv)] != 0);
      }
    }
    result.unexplained += is_reached ? 0 : 1;
  }
  result.cost += parameters.outlier_cost * result.unexplained;
  if (result.inliers > 0) result.mse = squared / result.inliers;
  return result;
}

TEST(ObservedImage, VerificationIsWhatTheDefinitionSays) {
  const Scene& scene = TheScene();
  ObservedImage observed;
  observed.Reset(scene.image(), VerificationParameters{}.edge_px);
  ModelView view;
  Rng rng(2);
  Verification sum;
  for (int trial = 0; trial < 24; ++trial) {
    const auto cluster = static_cast<size_t>(trial % 2);
    const int step = 1 + trial / 2 % 4;
    const Pose T = scene.Hypothesis(cluster, trial, rng);
    const Verification result = Verify(ShapeOf(scene.mesh), T, &observed, cluster, step, {}, &view);
    const Verification expected = Reference(scene, T, cluster, step);
    // Single precision may decide otherwise for a pixel at the tolerance.
    EXPECT_NEAR(result.inliers, expected.inliers, 1);
    EXPECT_NEAR(result.occluded, expected.occluded, 1);
    EXPECT_NEAR(result.seen_through, expected.seen_through, 1);
    EXPECT_NEAR(result.in_front, expected.in_front, 1);
    EXPECT_EQ(result.missing, expected.missing);
    EXPECT_NEAR(result.edge, expected.edge, 1);
    EXPECT_EQ(result.unexplained, expected.unexplained);
    EXPECT_NEAR(result.mse, expected.mse, 1e-3 * expected.mse);
    EXPECT_NEAR(result.cost, expected.cost, 20.0);
    sum.inliers += result.inliers;
    sum.occluded += result.occluded;
    sum.seen_through += result.seen_through;
    sum.in_front += result.in_front;
    sum.edge += result.edge;
    sum.unexplained += result.unexplained;
  }
  for (const int count : {sum.inliers, sum.seen_through, sum.in_front, sum.edge, sum.unexplained}) {
    EXPECT_GT(count, 100);
  }
  EXPECT_GT(sum.occluded, 0);
}

TEST(ObservedImage, WhatWasPreparedBeforeDoesNotMatter) {
  const Scene& scene = TheScene();
  ObservedImage reused;
  reused.Reset(scene.image(), VerificationParameters{}.edge_px);
  ModelView view;
  Rng rng(3);
  for (int trial = 0; trial < 16; ++trial) {
    const auto cluster = static_cast<size_t>(trial / 3 % 2);
    const int step = 1 + trial % 3;
    const Pose T = scene.Hypothesis(cluster, 2 * trial, rng);
    ModelView fresh_view(SimdPath::kBaseline);
    const Verification alone =
        Verify(ShapeOf(scene.mesh), T, scene.image(), cluster, step, {}, &fresh_view);
    ExpectSame(Verify(ShapeOf(scene.mesh), T, &reused, cluster, step, {}, &view), alone);
  }
}

TEST(ObservedImage, ABoundEndsTheComparisonEarly) {
  const Scene& scene = TheScene();
  ObservedImage observed;
  observed.Reset(scene.image(), VerificationParameters{}.edge_px);
  ModelView view;
  Rng rng(4);
  for (int trial = 0; trial < 10; ++trial) {
    const Pose T = scene.Hypothesis(0, trial, rng);
    const ModelShape shape = ShapeOf(scene.mesh);
    const Verification whole = Verify(shape, T, &observed, 0, 2, {}, &view);
    ExpectSame(Verify(shape, T, &observed, 0, 2, {}, &view, whole.cost), whole);
    for (const double share : {0.0, 0.3, 0.9, 0.999}) {
      const Verification ended =
          Verify(shape, T, &observed, 0, 2, {}, &view, share * whole.cost - 1e-9);
      EXPECT_GT(ended.cost, share * whole.cost - 1e-9);
      EXPECT_LE(ended.cost, whole.cost);
    }
  }
}

TEST(ObservedImage, AllocatesNothingOnceWarm) {
  const Scene& scene = TheScene();
  ObservedImage observed;
  ModelView view;
  std::vector<uint8_t> explained(scene.depth.depth.size(), 0);
  size_t before = 0;
  for (int round = 0; round < 3; ++round) {
    before = BytesAllocated();
    Rng rng(5);
    observed.Reset(scene.image(), VerificationParameters{}.edge_px);
    for (int trial = 0; trial < 12; ++trial) {
      const auto cluster = static_cast<size_t>(trial % 2);
      const Pose T = scene.Hypothesis(cluster, trial, rng);
      Verify(ShapeOf(scene.mesh), T, &observed, cluster, 1 << (trial % 3), {}, &view);
    }
    MarkExplained(ShapeOf(scene.mesh), scene.poses[0], &observed, {}, &view, &explained);
  }
  EXPECT_EQ(BytesAllocated() - before, 0U);
}

TEST(ObservedImage, WithstandsEmptyClustersAndBadPoses) {
  const Scene& scene = TheScene();
  Segmentation segmentation = scene.segmentation;
  segmentation.clusters.emplace_back();
  segmentation.clusters.back().first_label = segmentation.clusters.back().last_label = 2;
  ObservedImage observed;
  observed.Reset({scene.depth, kCamera, segmentation}, VerificationParameters{}.edge_px);
  ModelView view;
  const Verification none = Verify(ShapeOf(scene.mesh), scene.poses[0], &observed, 2, 1, {}, &view);
  EXPECT_EQ(none.unexplained, 0);
  EXPECT_GT(none.inliers, 0);
  const DrawableMesh nothing(TriangleMesh{});
  const Verification undrawn = Verify(ShapeOf(nothing), scene.poses[0], &observed, 0, 1, {}, &view);
  EXPECT_EQ(static_cast<size_t>(undrawn.unexplained), segmentation.clusters[0].pixels.size());
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(), 1e300, -3.0}) {
    Pose T = scene.poses[0];
    T.translation().z() = bad;
    const Verification result = Verify(ShapeOf(scene.mesh), T, &observed, 0, 4, {}, &view);
    EXPECT_EQ(result.inliers, 0);
    EXPECT_GT(result.unexplained, 0);
    EXPECT_TRUE(std::isfinite(result.cost));
  }
  // All of the image is one cluster, larger than the model.
  Segmentation wide = scene.segmentation;
  std::fill(wide.labels.begin(), wide.labels.end(), 0);
  wide.clusters[0].window = {0, 0, kCamera.width - 1, kCamera.height - 1};
  const Verification small =
      Verify(ShapeOf(scene.mesh), scene.poses[0], {scene.depth, kCamera, wide}, 0, 1, {}, &view);
  EXPECT_GT(small.unexplained, kCamera.width * kCamera.height / 2);
  DepthImage blind(kCamera.width, kCamera.height);
  const Verification unseen = Verify(
      ShapeOf(scene.mesh), scene.poses[0], {blind, kCamera, scene.segmentation}, 0, 1, {}, &view);
  EXPECT_EQ(unseen.inliers + unseen.seen_through + unseen.in_front + unseen.edge, 0);
  EXPECT_GT(unseen.missing, 0);
}

}  // namespace
}  // namespace vantage
