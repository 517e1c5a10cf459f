#include "perception/estimator/pose_estimator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "perception/model/model_builder.h"
#include "perception/model/model_generator.h"
#include "perception/ppf/ppf_estimator.h"
#include "perception/shot/shot_estimator.h"
#include "tests/bus/fuzz/count_allocations.h"
#include "tests/perception/test_scenes.h"

namespace vantage {
namespace {

ObjectModel Build(const std::string& name) {
  const GeneratedObject object = GenerateObject(name).value();
  return BuildObjectModel(name, object.mesh, object.symmetry, "generated", {}).value();
}

const ObjectModel& Bracket() {
  static const ObjectModel model = Build("bracket");
  return model;
}

// Brackets on a table, seen obliquely.
struct Scene {
  CameraModel camera;
  DepthImage depth;
  std::vector<Pose> T_camera_object;

  Scene(std::span<const Pose> T_world_object, uint64_t seed) {
    const Pose T_camera_world = LookAt({0.5, 0.1, 0.5}, {0.0, 0.0, 0.03}).inverse();
    DepthRasterizer rasterizer(camera);
    rasterizer.Draw(MakeTable(1.2F), T_camera_world);
    for (const Pose& T : T_world_object) {
      T_camera_object.push_back(T_camera_world * T);
      rasterizer.Draw(Bracket().mesh, T_camera_object.back());
    }
    depth = ToImage(rasterizer);
    Rng rng(seed);
    AddNoise(camera.fx, 0.0014, 0.125, rng, &depth);
  }
};

Pose Standing(double x, double y, double turn) {
  return Pose(Eigen::Translation3d(x, y, 0.0) * Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()));
}

std::unique_ptr<PoseEstimator> BracketEstimator() {
  return std::move(CreatePpfEstimator(std::vector<ObjectModel>{Bracket()}, {})).value();
}

// rad and m to the nearest of the scene's objects.
std::pair<double, double> Error(const Detection& detection, const Scene& scene) {
  std::pair<double, double> best{10.0, 10.0};
  for (const Pose& T : scene.T_camera_object) {
    const double distance =
        (detection.T_camera_object * Bracket().center - T * Bracket().center).norm();
    if (distance >= best.second) continue;
    best = {GeodesicAngle(Eigen::Quaterniond(detection.T_camera_object.linear()),
                          Eigen::Quaterniond(T.linear())),
            distance};
  }
  return best;
}

TEST(PoseEstimator, FindsSeveralInstancesOfAModel) {
  const std::vector<Pose> places = {
      Standing(0.0, -0.22, 0.3), Standing(0.05, 0.02, 2.0), Standing(-0.05, 0.25, 4.4)};
  const Scene scene(places, 1);
  Rng rng(1);
  const auto estimator = BracketEstimator();
  const PoseEstimator::Output& output = estimator->Estimate(scene.depth, scene.camera, rng);
  ASSERT_EQ(output.detections.size(), 3U);
  for (const Detection& detection : output.detections) {
    const auto [angle, distance] = Error(detection, scene);
    EXPECT_LT(angle, 2.0 * kDegree);
    EXPECT_LT(distance, 0.002);
    EXPECT_FALSE(detection.touches_border);
  }
}

TEST(PoseEstimator, CovarianceIsOfThisSizeOfError) {
  const auto estimator = BracketEstimator();
  for (int trial = 0; trial < 5; ++trial) {
    const std::vector<Pose> places = {Standing(0.02 * trial, 0.0, 1.3 * trial)};
    const Scene scene(places, 2 + static_cast<uint64_t>(trial));
    Rng rng(1);
    const PoseEstimator::Output& output = estimator->Estimate(scene.depth, scene.camera, rng);
    ASSERT_EQ(output.detections.size(), 1U);
    const auto& covariance = output.detections[0].covariance;
    EXPECT_EQ(covariance, covariance.transpose());
    const auto [angle, distance] = Error(output.detections[0], scene);
    const double turn = std::sqrt(covariance.topLeftCorner<3, 3>().trace());
    const double shift = std::sqrt(covariance.bottomRightCorner<3, 3>().trace());
    EXPECT_LT(angle, 4.0 * turn);
    EXPECT_LT(distance, 4.0 * shift);
    EXPECT_LT(turn, 2.0 * kDegree);
    EXPECT_LT(shift, 0.003);
  }
}

TEST(PoseEstimator, FlagsWhatReachesOutOfTheImage) {
  // The camera looks past the object, whose left part is cut off.
  const Pose T_camera_world = LookAt({0.5, 0.0, 0.5}, {0.0, 0.33, 0.03}).inverse();
  CameraModel camera;
  DepthRasterizer rasterizer(camera);
  rasterizer.Draw(MakeTable(2.0F), T_camera_world);
  rasterizer.Draw(Bracket().mesh, T_camera_world * Standing(0.0, 0.0, 0.4));
  const DepthImage depth = ToImage(rasterizer);
  PpfEstimatorParameters parameters;
  parameters.estimation.verification.min_score = 0.3;
  const auto estimator =
      CreatePpfEstimator(std::vector<ObjectModel>{Bracket()}, parameters).value();
  Rng rng(1);
  const PoseEstimator::Output& output = estimator->Estimate(depth, camera, rng);
  ASSERT_FALSE(output.detections.empty());
  EXPECT_TRUE(output.detections[0].touches_border);
}

TEST(PoseEstimator, IsTheSameWhateverWasEstimatedBefore) {
  const std::vector<Pose> places = {Standing(0.0, 0.0, 0.7)};
  const std::vector<Pose> others = {Standing(0.1, 0.1, 2.7), Standing(-0.1, -0.2, 0.1)};
  const Scene scene(places, 3);
  const Scene other(others, 4);
  const auto fresh = BracketEstimator();
  const auto used = BracketEstimator();
  Rng before(9);
  used->Estimate(other.depth, other.camera, before);
  Rng a(5);
  Rng b(5);
  const PoseEstimator::Output first = fresh->Estimate(scene.depth, scene.camera, a);
  const PoseEstimator::Output second = used->Estimate(scene.depth, scene.camera, b);
  ASSERT_EQ(first.detections.size(), second.detections.size());
  ASSERT_FALSE(first.detections.empty());
  for (size_t i = 0; i < first.detections.size(); ++i) {
    EXPECT_EQ(first.detections[i].T_camera_object.matrix(),
              second.detections[i].T_camera_object.matrix());
    EXPECT_EQ(first.detections[i].covariance, second.detections[i].covariance);
    EXPECT_EQ(first.detections[i].mse, second.detections[i].mse);
  }
}

TEST(PoseEstimator, AllocatesNothingOnceWarm) {
  const std::vector<Pose> places = {Standing(0.0, -0.2, 0.3), Standing(0.0, 0.1, 2.0)};
  const Scene scene(places, 6);
  const auto estimator = BracketEstimator();
  for (int i = 0; i < 2; ++i) {
    Rng rng(1);
    estimator->Estimate(scene.depth, scene.camera, rng);
  }
  Rng rng(1);
  const size_t before = BytesAllocated();
  const PoseEstimator::Output& output = estimator->Estimate(scene.depth, scene.camera, rng);
  EXPECT_EQ(BytesAllocated() - before, 0U);
  EXPECT_EQ(output.detections.size(), 2U);
}

TEST(PoseEstimator, SenselessImagesGiveNothing) {
  const auto estimator = BracketEstimator();
  const CameraModel camera = SmallCamera();
  const float inf = std::numeric_limits<float>::infinity();
  for (const float fill : {DepthImage::kInvalid, 0.0F, -1.0F, inf, 0.7F, 65.535F, 1e30F}) {
    const DepthImage depth(camera.width, camera.height, fill);
    Rng rng(1);
    EXPECT_TRUE(estimator->Estimate(depth, camera, rng).detections.empty()) << fill;
  }
  // A plane alone, and a cluster far larger than the model.
  DepthRasterizer rasterizer(camera);
  const Pose T_camera_world = LookAt({0.5, 0.0, 0.5}, {0.0, 0.0, 0.0}).inverse();
  rasterizer.Draw(MakeTable(3.0F), T_camera_world);
  Rng plane_rng(1);
  EXPECT_TRUE(estimator->Estimate(ToImage(rasterizer), camera, plane_rng).detections.empty());
  rasterizer.Draw(MakeBox({-0.3F, -0.3F, 0.0F}, {0.1F, 0.3F, 0.2F}), T_camera_world);
  Rng box_rng(1);
  EXPECT_TRUE(estimator->Estimate(ToImage(rasterizer), camera, box_rng).detections.empty());
}

TEST(PoseEstimator, RefusesModelsInAnotherUnit) {
  const GeneratedObject object = GenerateObject("bracket").value();
  for (const float scale : {1000.0F, 0.001F}) {
    TriangleMesh mesh = object.mesh;
    for (Eigen::Vector3f& vertex : mesh.vertices) vertex *= scale;
    const Result<ObjectModel> model =
        BuildObjectModel("bracket", mesh, object.symmetry, "generated", {});
    if (!model) {
      EXPECT_NE(model.error().message.find("m"), std::string::npos);
      continue;
    }
    const auto ppf = CreatePpfEstimator(std::vector<ObjectModel>{*model}, {});
    ASSERT_FALSE(ppf.ok());
    EXPECT_NE(ppf.error().message.find("millimetres"), std::string::npos) << ppf.error().message;
  }
}

TEST(ShotEstimator, FindsAnObjectOnATable) {
  const auto estimator = CreateShotEstimator(std::vector<ObjectModel>{Bracket()}, {}).value();
  const std::vector<Pose> places = {Standing(0.0, 0.0, 0.9)};
  const Scene scene(places, 7);
  Rng rng(1);
  const PoseEstimator::Output& output = estimator->Estimate(scene.depth, scene.camera, rng);
  ASSERT_EQ(output.detections.size(), 1U);
  const auto [angle, distance] = Error(output.detections[0], scene);
  EXPECT_LT(angle, 2.0 * kDegree);
  EXPECT_LT(distance, 0.002);
}

}  // namespace
}  // namespace vantage
