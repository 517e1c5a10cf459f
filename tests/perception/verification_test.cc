#include "perception/verification/verification.h"

#include <gtest/gtest.h>

#include <cmath>

#include "perception/verification/mesh_simplification.h"
#include "tests/perception/test_scenes.h"

namespace vantage {
namespace {

const CameraModel kCamera = SmallCamera();

ModelShape ShapeOf(const DrawableMesh& drawable) {
  const TriangleMesh& mesh = drawable.mesh();
  ModelShape shape{drawable, mesh.SurfaceCentroid(), mesh.Diameter(), 0.0};
  for (const Eigen::Vector3f& vertex : mesh.vertices) {
    shape.radius = std::max(shape.radius, (vertex.cast<double>() - shape.center).norm());
  }
  return shape;
}

DepthImage Render(const DrawableMesh& drawable, const Pose& T_camera_mesh) {
  DepthRasterizer rasterizer(kCamera);
  rasterizer.Draw(drawable.mesh(), T_camera_mesh);
  return ToImage(rasterizer);
}

Segmentation AllOneCluster(const DepthImage& depth) {
  SegmentationParameters parameters;
  parameters.support = SegmentationParameters::Support::kNone;
  parameters.largest_gap = 10.0;
  Rng rng(1);
  return Segment(depth, kCamera, parameters, rng);
}

Pose At(double x, double y, double z) { return Pose(Eigen::Translation3d(x, y, z)); }

// A plate that faces the camera: every number can be computed by hand.
const DrawableMesh kPlate(MakeBox({-0.05F, -0.05F, 0.0F}, {0.05F, 0.05F, 0.002F}));

TEST(ModelView, ShowsEveryStepthPixelOfTheWholeImage) {
  const DrawableMesh mesh(MakeAsymmetric());
  const ModelShape shape = ShapeOf(mesh);
  Rng rng(2);
  for (int trial = 0; trial < 30; ++trial) {
    Pose T(rng.Rotation());
    // Some reach over the border.
    T.translation() = Eigen::Vector3d(rng.Uniform(-0.3, 0.3), rng.Uniform(-0.3, 0.3), 0.6);
    DepthRasterizer whole(kCamera);
    whole.Draw(mesh.mesh(), T);
    const int step = 1 + trial % 4;
    ModelView view;
    view.Render(mesh, T, kCamera, ModelWindow(kCamera, shape, T), step);
    size_t shown = 0;
    view.ForEachPixel([&](const ModelView::Pixel& pixel) {
      const auto index = static_cast<size_t>(pixel.v * kCamera.width + pixel.u);
      EXPECT_EQ(pixel.u % step, 0);
      EXPECT_EQ(pixel.v % step, 0);
      EXPECT_NEAR(pixel.depth, whole.depth()[index], 1e-4);
      EXPECT_TRUE(view.Shows(pixel.u, pixel.v, 0));
      ++shown;
    });
    size_t expected = 0;
    for (int v = 0; v < kCamera.height; v += step) {
      for (int u = 0; u < kCamera.width; u += step) {
        const auto index = static_cast<size_t>(v * kCamera.width + u);
        expected += whole.depth()[index] != DepthRasterizer::kEmpty ? 1U : 0U;
      }
    }
    // Pixels on an edge may fall to either side of the rounding.
    EXPECT_NEAR(static_cast<double>(shown), static_cast<double>(expected), 2.0);
  }
}

TEST(ModelView, OfAWindowBehindTheCameraIsEmpty) {
  EXPECT_TRUE(BallWindow(kCamera, {0.0, 0.0, 0.1}, 0.2).empty());
  EXPECT_TRUE(BallWindow(kCamera, {0.0, 0.0, -1.0}, 0.2).empty());
  EXPECT_TRUE(BallWindow(kCamera, {0.0, 0.0, std::nan("")}, 0.2).empty());
  EXPECT_TRUE(BallWindow(kCamera, {50.0, 0.0, 1.0}, 0.2).empty());
  ModelView view;
  view.Render(kPlate, At(0, 0, -1), kCamera, BallWindow(kCamera, {0, 0, -1}, 0.1), 1);
  EXPECT_TRUE(view.empty());
  EXPECT_FALSE(view.Shows(100, 100, 3));
}

TEST(Verify, TruePoseIsConfirmedWholly) {
  const DepthImage depth = Render(kPlate, At(0, 0, 0.7));
  const Segmentation segmentation = AllOneCluster(depth);
  ModelView view;
  const Verification result =
      Verify(ShapeOf(kPlate), At(0, 0, 0.7), {depth, kCamera, segmentation}, 0, 1, {}, &view);
  EXPECT_EQ(static_cast<size_t>(result.inliers), segmentation.clusters[0].pixels.size());
  EXPECT_DOUBLE_EQ(result.score(), 1.0);
  EXPECT_DOUBLE_EQ(result.inlier_fraction(), 1.0);
  EXPECT_NEAR(result.mse, 0.0, 1e-12);
  EXPECT_NEAR(result.cost, 0.0, 1e-3);
}

TEST(Verify, MseIsSquaredDistanceToTheSurface) {
  // A shift along the view of a plate tilted by 40 deg: the distance to it is the cosine's part.
  Pose T = At(0, 0, 0.7);
  T.linear() = Eigen::AngleAxisd(40.0 * kDegree, Eigen::Vector3d::UnitX()).toRotationMatrix();
  const DepthImage depth = Render(kPlate, T);
  const Segmentation segmentation = AllOneCluster(depth);
  Pose shifted = T;
  shifted.translation().z() += 0.001;
  ModelView view;
  const Verification result =
      Verify(ShapeOf(kPlate), shifted, {depth, kCamera, segmentation}, 0, 1, {}, &view);
  const double distance = 0.001 * std::cos(40.0 * kDegree);
  EXPECT_NEAR(result.mse, distance * distance, 0.05 * distance * distance);
}

TEST(Verify, CountsEveryKindOfPixel) {
  // Left half: right. Right half, by quarters from above: measured farther, nearer on this cluster,
  // nearer on another cluster, nothing.
  const ModelShape shape = ShapeOf(kPlate);
  DepthImage depth = Render(kPlate, At(0, 0, 0.7));
  std::vector<uint32_t> plate;
  for (uint32_t i = 0; i < depth.depth.size(); ++i) {
    if (depth.depth[i] > 0.0F) plate.push_back(i);
  }
  Segmentation segmentation = AllOneCluster(depth);
  std::array<int, 5> expected{};
  const int v0 = segmentation.clusters[0].window.v0;
  const int v1 = segmentation.clusters[0].window.v1;
  std::erase_if(segmentation.clusters[0].pixels, [&](uint32_t pixel) {
    const int u = static_cast<int>(pixel) % kCamera.width;
    const int v = static_cast<int>(pixel) / kCamera.width;
    if (u < 160) {
      ++expected[0];
      return false;
    }
    const int quarter = 4 * (v - v0) / (v1 - v0 + 1);
    ++expected[static_cast<size_t>(quarter) + 1];
    depth.depth[pixel] =
        std::array{0.9F, 0.6F, 0.6F, DepthImage::kInvalid}[static_cast<size_t>(quarter)];
    segmentation.labels[pixel] = std::array{-1, 0, 1, -1}[static_cast<size_t>(quarter)];
    return quarter != 1;
  });
  VerificationParameters parameters;
  parameters.edge_px = 0;
  ModelView view;
  const SegmentedImage image{depth, kCamera, segmentation};
  const Verification result = Verify(shape, At(0, 0, 0.7), image, 0, 1, parameters, &view);
  EXPECT_EQ(result.inliers, expected[0]);
  EXPECT_EQ(result.seen_through, expected[1]);
  EXPECT_EQ(result.in_front, expected[2]);
  EXPECT_EQ(result.occluded, expected[3]);
  EXPECT_EQ(result.missing, expected[4]);
  EXPECT_EQ(result.unexplained, 0);
  const double against = expected[1] + expected[2];
  EXPECT_DOUBLE_EQ(result.score(), expected[0] / (expected[0] + against));
  EXPECT_NEAR(result.cost, parameters.outlier_cost * against, 1e-3);

  // Beside the cluster's true place, all of the cluster is unexplained.
  const Verification beside = Verify(shape, At(0.15, 0, 0.7), image, 0, 1, parameters, &view);
  EXPECT_EQ(static_cast<size_t>(beside.unexplained), segmentation.clusters[0].pixels.size());
  EXPECT_DOUBLE_EQ(beside.score(), 0.0);
}

TEST(Verify, TableInFrontOfTheModelSpeaksAgainstIt) {
  // Nearer, but of no cluster: a support, through which no object can be.
  DepthImage depth(kCamera.width, kCamera.height, 0.6F);
  Segmentation segmentation;
  segmentation.labels.assign(depth.depth.size(), Segmentation::kNoCluster);
  segmentation.clusters.resize(1);
  ModelView view;
  const Verification result =
      Verify(ShapeOf(kPlate), At(0, 0, 0.7), {depth, kCamera, segmentation}, 0, 1, {}, &view);
  EXPECT_GT(result.in_front, 1000);
  EXPECT_EQ(result.occluded, 0);
}

TEST(Verify, SilhouetteOffByAPixelIsNoEvidence) {
  const DepthImage depth = Render(kPlate, At(0, 0, 0.7));
  const Segmentation segmentation = AllOneCluster(depth);
  DepthImage walled = depth;  // A far wall behind, so that what sticks out is seen through.
  for (float& z : walled.depth) {
    if (std::isnan(z)) z = 2.0F;
  }
  const double pixel = 0.7 / kCamera.fx;
  ModelView view;
  const SegmentedImage image{walled, kCamera, segmentation};
  const Verification near = Verify(ShapeOf(kPlate), At(pixel, 0, 0.7), image, 0, 1, {}, &view);
  EXPECT_EQ(near.seen_through + near.unexplained, 0);
  EXPECT_GT(near.edge, 20);
  const Verification far = Verify(ShapeOf(kPlate), At(6 * pixel, 0, 0.7), image, 0, 1, {}, &view);
  EXPECT_GT(far.seen_through, 100);
  EXPECT_GT(far.unexplained, 100);
}

TEST(Verify, CoarseScoreApproachesFullScore) {
  const DrawableMesh mesh(MakeAsymmetric());
  const ModelShape shape = ShapeOf(mesh);
  Rng rng(3);
  ModelView view;
  for (int trial = 0; trial < 20; ++trial) {
    Pose T(rng.Rotation());
    T.translation() = Eigen::Vector3d(0.0, 0.0, 0.5);
    DepthImage depth = Render(mesh, T);
    AddNoise(kCamera.fx, 0.0014, 0.0, rng, &depth);
    const Segmentation segmentation = AllOneCluster(depth);
    const SegmentedImage image{depth, kCamera, segmentation};
    Pose hypothesis = T;
    hypothesis.linear() = T.linear() * ExpSo3(0.1 * trial * rng.UnitVector()).toRotationMatrix();
    const Verification full = Verify(shape, hypothesis, image, 0, 1, {}, &view);
    const Verification coarse = Verify(shape, hypothesis, image, 0, 4, {}, &view);
    EXPECT_NEAR(coarse.score(), full.score(), 0.12) << trial;
  }
}

TEST(MarkExplained, MarksWhatIsMeasuredOnTheModel) {
  DepthImage depth = Render(kPlate, At(0, 0, 0.7));
  const Segmentation segmentation = AllOneCluster(depth);
  const std::vector<uint32_t>& pixels = segmentation.clusters[0].pixels;
  for (size_t i = 0; i < pixels.size(); i += 2) depth.depth[pixels[i]] = 0.8F;
  std::vector<uint8_t> explained(depth.depth.size(), 0);
  ModelView view;
  MarkExplained(
      ShapeOf(kPlate), At(0, 0, 0.7), {depth, kCamera, segmentation}, {}, &view, &explained);
  for (size_t i = 0; i < pixels.size(); ++i) EXPECT_EQ(explained[pixels[i]], i % 2);
}

TEST(SimplifyMesh, KeepsShapeWithFewerTriangles) {
  const TriangleMesh mesh = MakeBox({-0.05F, -0.03F, -0.02F}, {0.05F, 0.03F, 0.02F}, 40);
  const TriangleMesh simple = SimplifyMesh(mesh, 0.006);
  EXPECT_LT(simple.triangles.size(), mesh.triangles.size() / 4);
  EXPECT_NEAR(simple.Area(), mesh.Area(), 0.1 * mesh.Area());
  for (const Eigen::Vector3f& vertex : simple.vertices) {
    const Eigen::Vector3f inside = Eigen::Vector3f(0.05F, 0.03F, 0.02F) - vertex.cwiseAbs();
    EXPECT_GE(inside.minCoeff(), -1e-6F);
    EXPECT_LE(inside.minCoeff(), 0.006F);
  }
  for (size_t i = 0; i < simple.triangles.size(); ++i) {
    const auto& [a, b, c] = simple.triangles[i];
    const Eigen::Vector3f middle =
        (simple.vertices[a] + simple.vertices[b] + simple.vertices[c]) / 3.0F;
    EXPECT_GE(simple.ScaledNormal(i).dot(middle), -1e-9F);  // Outward still.
  }
}

TEST(VerificationParameters, RefuseValuesOutOfRange) {
  VerificationParameters parameters;
  EXPECT_TRUE(parameters.Validate().ok());
  parameters.min_score = 2.0;
  EXPECT_NE(parameters.Validate().error().message.find("min_score = 2"), std::string::npos);
  parameters = {};
  parameters.coarse_step = 0;
  EXPECT_FALSE(parameters.Validate().ok());
}

}  // namespace
}  // namespace vantage
