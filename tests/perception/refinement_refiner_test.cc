#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "perception/refinement/refiner.h"
#include "tests/bus/fuzz/count_allocations.h"
#include "tests/perception/test_scenes.h"

namespace vantage {
namespace {

const CameraModel kCamera = SmallCamera();
const TriangleMesh kMesh = MakeAsymmetric();

const DrawableMesh kDrawable(kMesh);

ModelShape ShapeOf(const DrawableMesh& drawable) {
  const TriangleMesh& mesh = drawable.mesh();
  return {drawable, mesh.SurfaceCentroid(), mesh.Diameter(), mesh.Diameter()};
}

struct View {
  Pose T_camera_object;
  DepthImage depth;
  Segmentation segmentation;

  View(const TriangleMesh& mesh, const Pose& T, double noise, Rng& rng) : T_camera_object(T) {
    DepthRasterizer rasterizer(kCamera);
    rasterizer.Draw(mesh, T);
    depth = ToImage(rasterizer);
    if (noise > 0.0) AddNoise(kCamera.fx, noise, 0.0, rng, &depth);
    SegmentationParameters parameters;
    parameters.support = SegmentationParameters::Support::kNone;
    parameters.largest_gap = 10.0;
    segmentation = Segment(depth, kCamera, parameters, rng);
  }
  [[nodiscard]] SegmentedImage image() const { return {depth, kCamera, segmentation}; }
};

// Seen from obliquely above, so that three kinds of faces show.
Pose RandomView(Rng& rng) {
  const double azimuth = rng.Uniform(0.0, 6.28);
  const double elevation = rng.Uniform(30.0, 60.0) * kDegree;
  const Eigen::Vector3d eye = 0.5 * Eigen::Vector3d(std::cos(elevation) * std::cos(azimuth),
                                                    std::cos(elevation) * std::sin(azimuth),
                                                    std::sin(elevation));
  return LookAt(eye, Eigen::Vector3d(0.05, 0.03, 0.03)).inverse();
}

Pose Disturbed(const Pose& T, double angle, double distance, Rng& rng) {
  const Eigen::Vector3d center = T * kMesh.SurfaceCentroid();
  Pose disturbed(Eigen::Translation3d(center + distance * rng.UnitVector()) *
                 ExpSo3(angle * rng.UnitVector()) * Eigen::Translation3d(-center));
  return disturbed * T;
}

double AngleBetween(const Pose& a, const Pose& b) {
  return GeodesicAngle(Eigen::Quaterniond(a.linear()), Eigen::Quaterniond(b.linear()));
}

Refined RefineOnce(const DrawableMesh& drawable,
                   const Pose& start,
                   const SegmentedImage& image,
                   const RefinementParameters& parameters) {
  Refiner refiner;
  ModelView view;
  const ModelShape shape = ShapeOf(drawable);
  return refiner.Refine(shape, shape, start, image, parameters, &view);
}

using Error = Eigen::Matrix<double, 6, 1>;

Error ErrorOf(const Refined& refined, const Pose& truth) {
  const Eigen::Vector3d center = kMesh.SurfaceCentroid();
  Error error;
  error << LogSo3(
      Eigen::Quaterniond(refined.T_camera_object.linear() * truth.linear().transpose())),
      refined.T_camera_object * center - truth * center;
  return error;
}

TEST(Refiner, RecoversThePoseOfExactDepth) {
  Rng rng(2);
  RefinementParameters parameters;
  parameters.converged = 0.0;
  parameters.final_iterations = 20;
  parameters.final_points = 1000000;  // All pixels.
  for (int trial = 0; trial < 10; ++trial) {
    const View seen(kMesh, RandomView(rng), 0.0, rng);
    const Pose start = Disturbed(seen.T_camera_object, 3.0 * kDegree, 0.004, rng);
    // Drawn twice, the model still lacks what was hidden at first.
    const Refined once = RefineOnce(kDrawable, start, seen.image(), parameters);
    const Refined refined = RefineOnce(kDrawable, once.T_camera_object, seen.image(), parameters);
    EXPECT_LT(AngleBetween(refined.T_camera_object, seen.T_camera_object), 0.03 * kDegree);
    EXPECT_LT((refined.T_camera_object.translation() - seen.T_camera_object.translation()).norm(),
              1e-4);
    EXPECT_LT(refined.rms, 1e-4);
    EXPECT_GT(refined.pairs, 500);
  }
}

TEST(Refiner, CovarianceTellsTheErrorUnderIndependentNoise) {
  Rng rng(3);
  RefinementParameters parameters;
  parameters.model_error = 0.0;
  parameters.correlated_px = 1.0;
  parameters.bias_at_1m = 0.0;
  parameters.bias_tilt = 0.0;
  parameters.fine_iterations = 0;
  parameters.final_points = 1000000;  // All pixels.
  // The noise that the weights assume: axial alone.
  parameters.noise = {0.0, 0.002, 0.0, 0.0};
  std::vector<double> squares;
  for (int trial = 0; trial < 60; ++trial) {
    const View seen(kMesh, RandomView(rng), 0.002, rng);
    const Refined refined = RefineOnce(kDrawable, seen.T_camera_object, seen.image(), parameters);
    const Error error = ErrorOf(refined, seen.T_camera_object);
    EXPECT_EQ(refined.covariance, refined.covariance.transpose()) << "as messages must be";
    squares.push_back(error.dot(refined.covariance.inverse() * error));
  }
  // Chi-square of 6 degrees of freedom: median 5.3, 95 % at 12.6. Outliers at creases widen it.
  std::sort(squares.begin(), squares.end());
  EXPECT_GT(squares[30], 3.0);
  EXPECT_LT(squares[30], 10.0);
  EXPECT_GT(squares[54], 6.0);
  EXPECT_LT(squares[54], 25.0);
}

TEST(Refiner, LeavesWhatNoMeasurementFixes) {
  // A plate seen head on: nothing tells its place and turn within its plane.
  const TriangleMesh plate = MakeBox({-0.05F, -0.05F, 0.0F}, {0.05F, 0.05F, 0.002F});
  Rng rng(4);
  Pose T = Pose::Identity();
  T.translation() = Eigen::Vector3d(0.0, 0.0, 0.6);
  const View seen(plate, T, 0.0, rng);
  Pose start = T;
  start.translation() += Eigen::Vector3d(0.003, -0.002, 0.004);
  const DrawableMesh drawable(plate);
  const Refined refined = RefineOnce(drawable, start, seen.image(), {});
  EXPECT_NEAR(refined.T_camera_object.translation().z(), 0.6, 1e-4);
  EXPECT_NEAR(refined.T_camera_object.translation().x(), 0.003, 1e-3);
  const double diameter = plate.Diameter();
  EXPECT_GT(refined.covariance(3, 3), 0.04 * diameter * diameter);
  EXPECT_GT(refined.covariance(2, 2), 0.5);
  EXPECT_LT(refined.covariance(5, 5), 1e-6);
}

TEST(Refiner, WithoutOverlapReturnsTheStart) {
  Rng rng(5);
  const View seen(kMesh, RandomView(rng), 0.0, rng);
  for (const Eigen::Vector3d& shift : {Eigen::Vector3d(0.3, 0.0, 0.0),
                                       Eigen::Vector3d(50.0, 0.0, 0.0),
                                       Eigen::Vector3d(0.0, 0.0, 2.0),
                                       Eigen::Vector3d(0.0, 0.0, -5.0)}) {
    Pose beside = seen.T_camera_object;
    beside.translation() += shift;
    const Refined refined = RefineOnce(kDrawable, beside, seen.image(), {});
    EXPECT_LT((refined.T_camera_object.matrix() - beside.matrix()).norm(), 1e-12);
    EXPECT_EQ(refined.pairs, 0);
    EXPECT_GT(refined.covariance(0, 0), 0.5);
  }
}

TEST(Refiner, BadDepthNeverMakesBadPoses) {
  Rng rng(6);
  const View clean(kMesh, RandomView(rng), 0.001, rng);
  constexpr float kInf = std::numeric_limits<float>::infinity();
  for (const float bad : {std::nanf(""), kInf, -kInf, 0.0F, -1.0F, 65.535F, 1e30F, 1e-30F}) {
    for (const double share : {0.3, 1.0}) {
      View seen = clean;
      for (float& depth : seen.depth.depth) {
        if (rng.Uniform() < share) depth = bad;
      }
      const Refined refined = RefineOnce(kDrawable, clean.T_camera_object, seen.image(), {});
      EXPECT_TRUE(refined.T_camera_object.matrix().allFinite());
      EXPECT_TRUE(refined.covariance.allFinite());
      EXPECT_LT(AngleBetween(refined.T_camera_object, clean.T_camera_object), 1.0 * kDegree);
      EXPECT_EQ(refined.pairs == 0, share == 1.0);
    }
  }
}

TEST(Refiner, OnePixelIsNotEnough) {
  Rng rng(7);
  View seen(kMesh, RandomView(rng), 0.0, rng);
  const Eigen::Vector2d middle = kCamera.Project(seen.T_camera_object * kMesh.SurfaceCentroid());
  const size_t kept = seen.depth.Index(static_cast<int>(middle.x()), static_cast<int>(middle.y()));
  for (size_t i = 0; i < seen.depth.depth.size(); ++i) {
    if (i != kept) seen.segmentation.labels[i] = Segmentation::kNoCluster;
  }
  const Refined refined = RefineOnce(kDrawable, seen.T_camera_object, seen.image(), {});
  EXPECT_EQ(refined.pairs, 0);
  EXPECT_LT((refined.T_camera_object.matrix() - seen.T_camera_object.matrix()).norm(), 1e-12);
}

TEST(Refiner, AllocatesNothingOnceWarm) {
  Rng rng(8);
  const View seen(kMesh, RandomView(rng), 0.001, rng);
  const Pose start = Disturbed(seen.T_camera_object, 3.0 * kDegree, 0.003, rng);
  const ModelShape shape = ShapeOf(kDrawable);
  const SegmentedImage image = seen.image();
  Refiner refiner;
  ModelView view;
  const Refined first = refiner.Refine(shape, shape, start, image, {}, &view);
  const size_t before = BytesAllocated();
  const Refined second = refiner.Refine(shape, shape, start, image, {}, &view);
  EXPECT_EQ(BytesAllocated(), before);
  EXPECT_EQ(first.T_camera_object.matrix(), second.T_camera_object.matrix());
  EXPECT_EQ(first.covariance, second.covariance);
}

}  // namespace
}  // namespace vantage
