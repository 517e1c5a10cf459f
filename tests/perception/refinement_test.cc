#include "perception/refinement/refinement.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

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

TEST(NearestGrid, FindsTheNearestToWithinACube) {
  Rng rng(1);
  const std::vector<SurfacePoint> points = SampleSurface(kMesh, 300, rng);
  const double cell = 0.003;
  const double reach = 0.02;
  const NearestGrid grid(points, reach, cell);
  const double slack = cell * std::sqrt(3.0);
  int found = 0;
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3f place(static_cast<float>(rng.Uniform(-0.05, 0.15)),
                                static_cast<float>(rng.Uniform(-0.05, 0.12)),
                                static_cast<float>(rng.Uniform(-0.05, 0.13)));
    double nearest = 1e9;
    for (const SurfacePoint& point : points) {
      nearest = std::min(nearest, static_cast<double>((point.position - place).norm()));
    }
    const uint32_t index = grid.Find(place);
    if (index == NearestGrid::kNone) {
      EXPECT_GT(nearest, reach - slack);
      continue;
    }
    ++found;
    const auto distance = static_cast<double>((grid.points()[index].position - place).norm());
    EXPECT_LE(distance, nearest + slack);
  }
  EXPECT_GT(found, 300);
  EXPECT_EQ(grid.Find({1e9F, 0.0F, 0.0F}), NearestGrid::kNone);
  EXPECT_EQ(grid.Find({std::nanf(""), 0.0F, 0.0F}), NearestGrid::kNone);
}

TEST(RefineFine, RecoversThePoseOfExactDepth) {
  Rng rng(2);
  ModelView view;
  RefinementParameters parameters;
  parameters.converged = 0.0;
  for (int trial = 0; trial < 10; ++trial) {
    const View seen(kMesh, RandomView(rng), 0.0, rng);
    const Pose start = Disturbed(seen.T_camera_object, 3.0 * kDegree, 0.004, rng);
    const Refined fine =
        RefineFine(ShapeOf(kDrawable), start, seen.image(), 2, 10, 0.008, parameters, &view);
    const Refined refined = RefineFine(
        ShapeOf(kDrawable), fine.T_camera_object, seen.image(), 1, 20, 0.0, parameters, &view);
    EXPECT_LT(AngleBetween(refined.T_camera_object, seen.T_camera_object), 0.02 * kDegree);
    EXPECT_LT((refined.T_camera_object.translation() - seen.T_camera_object.translation()).norm(),
              5e-5);
    EXPECT_LT(refined.rms, 5e-5);
    EXPECT_GT(refined.pairs, 500);
  }
}

TEST(RefineFine, CovarianceTellsTheErrorUnderIndependentNoise) {
  Rng rng(3);
  ModelView view;
  RefinementParameters parameters;
  parameters.model_error = 0.0;
  // The noise that the weights assume, on a surface seen head on: axial alone.
  parameters.noise = {0.0, 0.002, 0.0, 0.0};
  std::vector<double> squares;
  for (int trial = 0; trial < 40; ++trial) {
    const View seen(kMesh, RandomView(rng), 0.002, rng);
    const Refined refined = RefineFine(
        ShapeOf(kDrawable), seen.T_camera_object, seen.image(), 1, 8, 0.0, parameters, &view);
    const Eigen::Vector3d center = kMesh.SurfaceCentroid();
    Eigen::Matrix<double, 6, 1> error;
    error << LogSo3(Eigen::Quaterniond(refined.T_camera_object.linear() *
                                       seen.T_camera_object.linear().transpose())),
        refined.T_camera_object * center - seen.T_camera_object * center;
    squares.push_back(error.dot(refined.covariance.inverse() * error));
  }
  // Chi-square of 6 degrees of freedom: median 5.3. Outliers at creases widen it a little.
  std::sort(squares.begin(), squares.end());
  EXPECT_GT(squares[20], 3.0);
  EXPECT_LT(squares[20], 12.0);
}

TEST(RefineFine, LeavesWhatNoMeasurementFixes) {
  // A plate seen head on: nothing tells its place and turn within its plane.
  const TriangleMesh plate = MakeBox({-0.05F, -0.05F, 0.0F}, {0.05F, 0.05F, 0.002F});
  Rng rng(4);
  Pose T = Pose::Identity();
  T.translation() = Eigen::Vector3d(0.0, 0.0, 0.6);
  const View seen(plate, T, 0.0, rng);
  Pose start = T;
  start.translation() += Eigen::Vector3d(0.003, -0.002, 0.004);
  ModelView view;
  const DrawableMesh drawable(plate);
  const Refined refined =
      RefineFine(ShapeOf(drawable), start, seen.image(), 1, 10, 0.01, {}, &view);
  EXPECT_NEAR(refined.T_camera_object.translation().z(), 0.6, 1e-4);
  EXPECT_NEAR(refined.T_camera_object.translation().x(), 0.003, 1e-3);
  EXPECT_GT(refined.covariance(3, 3), 100.0 * refined.covariance(5, 5));
}

TEST(RefineFine, WithoutOverlapReturnsTheStart) {
  Rng rng(5);
  const View seen(kMesh, RandomView(rng), 0.0, rng);
  Pose beside = seen.T_camera_object;
  beside.translation().x() += 0.3;
  ModelView view;
  const Refined refined =
      RefineFine(ShapeOf(kDrawable), beside, seen.image(), 1, 5, 0.0, {}, &view);
  EXPECT_LT(AngleBetween(refined.T_camera_object, beside), 1e-6);
  EXPECT_EQ(refined.pairs, 0);
}

TEST(RefineCoarse, BringsVotedPosesIntoReachOfTheFineOne) {
  Rng rng(6);
  const NearestGrid grid(
      SampleSurface(kMesh, 4000, rng), 0.16 * kMesh.Diameter(), 0.02 * kMesh.Diameter());
  int near = 0;
  constexpr int kTrials = 40;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Pose T = RandomView(rng);
    std::vector<SurfacePoint> scene;
    for (const SurfacePoint& point : SampleSurface(kMesh, 600, rng)) {
      const Eigen::Vector3d p = T * point.position.cast<double>();
      const Eigen::Vector3d n = T.linear() * point.normal.cast<double>();
      if (n.dot(p) < 0.0) scene.push_back({p.cast<float>(), n.cast<float>()});
    }
    const Pose start = Disturbed(T, 10.0 * kDegree, 0.008, rng);
    const Refined refined =
        RefineCoarse(grid, ShapeOf(kDrawable), start, scene, kCamera.fx, RefinementParameters{});
    near += AngleBetween(refined.T_camera_object, T) < 2.0 * kDegree ? 1 : 0;
  }
  EXPECT_GE(near, kTrials * 9 / 10);
}

TEST(RefinementParameters, RefuseValuesOutOfRange) {
  RefinementParameters parameters;
  EXPECT_TRUE(parameters.Validate().ok());
  parameters.coarse_reach_end = 0.5;
  EXPECT_FALSE(parameters.Validate().ok());
}

}  // namespace
}  // namespace vantage
