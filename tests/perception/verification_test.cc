#include "perception/verification/verification.h"

#include <gtest/gtest.h>

#include <cmath>

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

// Of the image's first cluster.
Verification VerifyIn(const SegmentedImage& image,
                      const ModelShape& shape,
                      const Pose& T,
                      int step = 1,
                      const VerificationParameters& parameters = {}) {
  ModelView view;
  return Verify(shape, T, image, 0, step, parameters, &view);
}

Pose At(double x, double y, double z) { return Pose(Eigen::Translation3d(x, y, z)); }

// A plate that faces the camera: every number can be computed by hand.
const DrawableMesh kPlate(MakeBox({-0.05F, -0.05F, 0.0F}, {0.05F, 0.05F, 0.002F}));

TEST(Verify, TruePoseIsConfirmedWholly) {
  const DepthImage depth = Render(kPlate, At(0, 0, 0.7));
  const Segmentation segmentation = AllOneCluster(depth);
  const Verification result =
      VerifyIn({depth, kCamera, segmentation}, ShapeOf(kPlate), At(0, 0, 0.7));
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
  const Verification result = VerifyIn({depth, kCamera, segmentation}, ShapeOf(kPlate), shifted);
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
  const SegmentedImage image{depth, kCamera, segmentation};
  const Verification result = VerifyIn(image, shape, At(0, 0, 0.7), 1, parameters);
  EXPECT_EQ(result.inliers, expected[0]);
  EXPECT_EQ(result.seen_through, expected[1]);
  EXPECT_EQ(result.in_front, expected[2]);
  EXPECT_EQ(result.occluded, expected[3]);
  EXPECT_EQ(result.missing, expected[4]);
  EXPECT_EQ(result.unexplained, 0);
  const double against = expected[1] + expected[2];
  EXPECT_DOUBLE_EQ(result.score(), expected[0] / (expected[0] + against));
  // The plate is seen nearly head on.
  const double missing_cost = parameters.missing_cost * expected[4];
  EXPECT_NEAR(result.cost, parameters.outlier_cost * against + missing_cost, 0.01 * missing_cost);

  // Beside the cluster's true place, all of the cluster is unexplained.
  const Verification beside = VerifyIn(image, shape, At(0.15, 0, 0.7), 1, parameters);
  EXPECT_EQ(static_cast<size_t>(beside.unexplained), segmentation.clusters[0].pixels.size());
  EXPECT_DOUBLE_EQ(beside.score(), 0.0);
}

TEST(Verify, TableInFrontOfTheModelSpeaksAgainstIt) {
  // Nearer, but of no cluster: a support, through which no object can be.
  DepthImage depth(kCamera.width, kCamera.height, 0.6F);
  Segmentation segmentation;
  segmentation.labels.assign(depth.depth.size(), Segmentation::kNoCluster);
  segmentation.clusters.resize(1);
  const Verification result =
      VerifyIn({depth, kCamera, segmentation}, ShapeOf(kPlate), At(0, 0, 0.7));
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
  const SegmentedImage image{walled, kCamera, segmentation};
  const Verification near = VerifyIn(image, ShapeOf(kPlate), At(pixel, 0, 0.7));
  EXPECT_EQ(near.seen_through + near.unexplained, 0);
  EXPECT_GT(near.edge, 20);
  const Verification far = VerifyIn(image, ShapeOf(kPlate), At(6 * pixel, 0, 0.7));
  EXPECT_GT(far.seen_through, 100);
  EXPECT_GT(far.unexplained, 100);
}

TEST(Verify, CoarseScoreApproachesFullScore) {
  const DrawableMesh mesh(MakeAsymmetric());
  const ModelShape shape = ShapeOf(mesh);
  Rng rng(3);
  for (int trial = 0; trial < 20; ++trial) {
    Pose T(rng.Rotation());
    T.translation() = Eigen::Vector3d(0.0, 0.0, 0.5);
    DepthImage depth = Render(mesh, T);
    AddNoise(kCamera.fx, 0.0014, 0.0, rng, &depth);
    const Segmentation segmentation = AllOneCluster(depth);
    const SegmentedImage image{depth, kCamera, segmentation};
    Pose hypothesis = T;
    hypothesis.linear() = T.linear() * ExpSo3(0.1 * trial * rng.UnitVector()).toRotationMatrix();
    const Verification full = VerifyIn(image, shape, hypothesis, 1);
    const Verification coarse = VerifyIn(image, shape, hypothesis, 4);
    EXPECT_NEAR(coarse.score(), full.score(), 0.12) << trial;
  }
}

TEST(MarkExplained, MarksWhatIsMeasuredOnTheModel) {
  DepthImage depth = Render(kPlate, At(0, 0, 0.7));
  const Segmentation segmentation = AllOneCluster(depth);
  const std::vector<uint32_t>& pixels = segmentation.clusters[0].pixels;
  for (size_t i = 0; i < pixels.size(); i += 2) depth.depth[pixels[i]] = 0.8F;
  std::vector<uint8_t> explained(depth.depth.size(), 0);
  ObservedImage observed;
  observed.Reset({depth, kCamera, segmentation}, VerificationParameters{}.edge_px);
  ModelView view;
  MarkExplained(ShapeOf(kPlate), At(0, 0, 0.7), &observed, {}, &view, &explained);
  for (size_t i = 0; i < pixels.size(); ++i) EXPECT_EQ(explained[pixels[i]], i % 2);
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
