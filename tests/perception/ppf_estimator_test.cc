#include "perception/ppf/ppf_estimator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

#include "perception/model/mesh_import.h"
#include "perception/model/model_builder.h"
#include "perception/model/model_generator.h"
#include "perception/ppf/self_alignment.h"
#include "tests/perception/test_scenes.h"
#include "tools/support/png_image.h"

namespace vantage {
namespace {

ObjectModel Generated(const std::string& name) {
  Result<GeneratedObject> object = GenerateObject(name);
  EXPECT_TRUE(object.ok());
  Result<ObjectModel> model =
      BuildObjectModel(name, object->mesh, object->symmetry, "generated", {});
  EXPECT_TRUE(model.ok());
  return std::move(model).value();
}

const std::vector<ObjectModel>& Models() {
  static const std::vector<ObjectModel> models = {
      Generated("filter"), Generated("mug"), Generated("bracket")};
  return models;
}

PoseEstimator& Estimator() {
  static const std::unique_ptr<PoseEstimator> estimator =
      std::move(CreatePpfEstimator(Models(), {})).value();
  return *estimator;
}

struct Scene {
  CameraModel camera;
  Pose T_world_camera = Pose::Identity();
  std::vector<Pose> T_world_object;
  DepthImage depth;
};

// The three objects on a table, turned at random, seen by a noisy camera from 0.75 m.
Scene RandomScene(Rng& rng) {
  Scene scene;
  const double azimuth = rng.Uniform(0.0, 6.28);
  const double elevation = rng.Uniform(35.0, 65.0) * kDegree;
  scene.T_world_camera = LookAt(Eigen::Vector3d(0.75 * std::cos(elevation) * std::cos(azimuth),
                                                0.75 * std::cos(elevation) * std::sin(azimuth),
                                                0.75 * std::sin(elevation)),
                                Eigen::Vector3d(0.0, 0.0, 0.04));
  const Pose T_camera_world = scene.T_world_camera.inverse();
  DepthRasterizer rasterizer(scene.camera);
  rasterizer.Draw(MakeTable(1.2F), T_camera_world);
  for (size_t i = 0; i < Models().size(); ++i) {
    const double around = azimuth + 0.4 + 2.1 * static_cast<double>(i);
    const Pose T(Eigen::Translation3d(0.15 * std::cos(around), 0.15 * std::sin(around), 0.0) *
                 Eigen::AngleAxisd(rng.Uniform(0.0, 6.28), Eigen::Vector3d::UnitZ()));
    scene.T_world_object.push_back(T);
    rasterizer.Draw(Models()[i].mesh, T_camera_world * T);
  }
  scene.depth = ToImage(rasterizer);
  AddNoise(scene.camera.fx, 0.0014, 0.125, rng, &scene.depth);
  return scene;
}

TEST(PpfEstimator, FindsThreeObjectsOnATable) {
  Rng rng(1);
  constexpr int kScenes = 8;
  std::vector<int> right(Models().size(), 0);
  for (int trial = 0; trial < kScenes; ++trial) {
    const Scene scene = RandomScene(rng);
    const PoseEstimator::Output output = Estimator().Estimate(scene.depth, scene.camera, rng);
    EXPECT_LE(output.detections.size(), Models().size());
    for (const Detection& detection : output.detections) {
      const auto model = std::find_if(Models().begin(), Models().end(), [&](const auto& known) {
        return known.id == detection.model_id;
      });
      ASSERT_NE(model, Models().end());
      const auto i = static_cast<size_t>(model - Models().begin());
      const Pose T_camera_object = scene.T_world_camera.inverse() * scene.T_world_object[i];
      const Eigen::Vector3d off =
          detection.T_camera_object * model->center - T_camera_object * model->center;
      const double angle = SymmetricAngle(model->symmetry,
                                          Eigen::Quaterniond(detection.T_camera_object.linear()),
                                          Eigen::Quaterniond(T_camera_object.linear()));
      right[i] += off.norm() < 0.05 * model->diameter && angle < 5.0 * kDegree ? 1 : 0;
      EXPECT_GE(detection.verification_score, 0.8);
      EXPECT_LE(detection.verification_score, 1.0);
      EXPECT_GE(detection.inlier_fraction, detection.verification_score);
      EXPECT_LT(detection.mse, 1e-5);
    }
  }
  EXPECT_GE(right[0], kScenes - 1);
  EXPECT_GE(right[1], kScenes - 3);  // The mug's handle is hidden in some views.
  EXPECT_GE(right[2], kScenes - 1);
}

TEST(PpfEstimator, IsTheSameForTheSameSeed) {
  Rng rng(2);
  const Scene scene = RandomScene(rng);
  Rng a(3);
  Rng b(3);
  const PoseEstimator::Output first = Estimator().Estimate(scene.depth, scene.camera, a);
  const PoseEstimator::Output second = Estimator().Estimate(scene.depth, scene.camera, b);
  ASSERT_EQ(first.detections.size(), second.detections.size());
  ASSERT_FALSE(first.detections.empty());
  for (size_t i = 0; i < first.detections.size(); ++i) {
    EXPECT_EQ(first.detections[i].T_camera_object.matrix(),
              second.detections[i].T_camera_object.matrix());
    EXPECT_EQ(first.detections[i].mse, second.detections[i].mse);
  }
}

TEST(PpfEstimator, FindsNothingInNothing) {
  const CameraModel camera = SmallCamera();
  Rng rng(4);
  const auto count = [&](const DepthImage& depth) {
    return Estimator().Estimate(depth, camera, rng).detections.size();
  };
  EXPECT_EQ(count(DepthImage(320, 240)), 0U);
  EXPECT_EQ(count(DepthImage(320, 240, 0.7F)), 0U);
  EXPECT_EQ(count(DepthImage(320, 240, 0.0F)), 0U);
  EXPECT_EQ(count(DepthImage(320, 240, std::numeric_limits<float>::infinity())), 0U);
  DepthImage table(320, 240);
  DepthRasterizer rasterizer(camera);
  rasterizer.Draw(MakeTable(1.2F), LookAt({0.5, 0.0, 0.5}, {0.0, 0.0, 0.0}).inverse());
  EXPECT_EQ(count(ToImage(rasterizer)), 0U);
  DepthImage noise(320, 240);
  for (float& z : noise.depth) z = static_cast<float>(rng.Uniform(0.3, 2.0));
  EXPECT_EQ(count(noise), 0U);
}

TEST(PpfEstimator, SmallestClustersDoNoHarm) {
  PpfEstimatorParameters parameters;
  parameters.estimation.segmentation.support = SegmentationParameters::Support::kNone;
  parameters.estimation.segmentation.min_points = 1;
  Result<std::unique_ptr<PoseEstimator>> estimator =
      CreatePpfEstimator(std::vector<ObjectModel>{Models()[2]}, parameters);
  ASSERT_TRUE(estimator.ok());
  DepthImage depth(320, 240);
  depth.at(100, 100) = 0.7F;
  for (int u = 150; u < 200; ++u) depth.at(u, 120) = 0.6F;
  Rng rng(5);
  const PoseEstimator::Output output = (*estimator)->Estimate(depth, SmallCamera(), rng);
  EXPECT_EQ(output.num_clusters, 2);
  EXPECT_TRUE(output.detections.empty());
}

TEST(PpfEstimator, AnUnknownObjectIsNoDetection) {
  // A ball-like thing of the bracket's size.
  PpfEstimatorParameters parameters;
  Result<std::unique_ptr<PoseEstimator>> estimator =
      CreatePpfEstimator(std::vector<ObjectModel>{Models()[2]}, parameters);
  ASSERT_TRUE(estimator.ok());
  CameraModel camera;
  DepthRasterizer rasterizer(camera);
  const Pose T_camera_world = LookAt({0.5, 0.0, 0.5}, {0.0, 0.0, 0.0}).inverse();
  rasterizer.Draw(MakeTable(1.2F), T_camera_world);
  rasterizer.Draw(Generated("bottle").mesh, T_camera_world);
  Rng rng(6);
  EXPECT_TRUE((*estimator)->Estimate(ToImage(rasterizer), camera, rng).detections.empty());
}

TEST(PpfEstimator, RefusesParametersOutOfRange) {
  PpfEstimatorParameters parameters;
  parameters.estimation.fine_hypotheses = 0;
  EXPECT_FALSE(CreatePpfEstimator(Models(), parameters).ok());
}

std::vector<Pose> SelfAlignmentsOf(const ObjectModel& model) {
  Rng rng(7);
  const PpfTable table = std::move(PpfTable::Train(model.samples, model.diameter, {})).value();
  const NearestGrid grid(
      SampleSurface(model.mesh, 4000, rng), 0.16 * model.diameter, 0.02 * model.diameter);
  const DrawableMesh mesh(model.mesh);
  return FindSelfAlignments(
      table, grid, {mesh, model.center, model.diameter, model.diameter}, model.symmetry, rng);
}

TEST(FindSelfAlignments, FindsHalfTurnOfTheFilterAndTurnsOfTheMug) {
  const std::vector<Pose> filter = SelfAlignmentsOf(Models()[0]);
  EXPECT_TRUE(std::any_of(filter.begin(), filter.end(), [](const Pose& T) {
    const Eigen::AngleAxisd turn(T.linear());
    return turn.angle() > 175.0 * kDegree && std::abs(turn.axis().z()) > 0.99;
  }));
  const std::vector<Pose> mug = SelfAlignmentsOf(Models()[1]);
  EXPECT_GE(mug.size(), 18U);  // All round in steps of 10 to 20 deg.
  EXPECT_TRUE(SelfAlignmentsOf(Models()[2]).empty());
}

struct RealView {
  DepthImage depth;
  Eigen::Quaterniond rotation;
  Eigen::Vector3d translation;
};

// Every `stride`-th of the recorded views of a printed bunny; empty when they aren't there.
std::vector<RealView> RealViews(const std::filesystem::path& folder, int stride) {
  std::vector<RealView> views;
  std::ifstream csv(folder / "camera_T_model.csv");
  std::string line;
  std::getline(csv, line);
  while (std::getline(csv, line)) {
    std::vector<double> values;
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) values.push_back(std::stod(cell));
    const int number = static_cast<int>(values[0]);
    if (number % stride != 0) continue;
    constexpr size_t kFirst = 13;  // Of the pose that was refined on the view's own depth.
    Eigen::Matrix3d R;
    RealView view;
    for (int row = 0; row < 3; ++row) {
      const size_t at = kFirst + 4 * static_cast<size_t>(row);
      R.row(row) << values[at], values[at + 1], values[at + 2];
      view.translation(row) = values[at + 3];
    }
    view.rotation = Eigen::Quaterniond(R).normalized();
    std::string name = std::to_string(number);
    name = "depth_" + std::string(2 - name.size(), '0') + name + ".png";
    const Result<Gray16Image> png = ReadPng16(folder / name);
    if (!png) return {};
    view.depth = DepthFromMillimetres(png->width, png->height, png->gray.data());
    views.push_back(std::move(view));
  }
  return views;
}

TEST(PpfEstimator, FindsTheBunnyInRealViews) {
  const std::filesystem::path data = std::filesystem::path(VANTAGE_SOURCE_DIR) / "../shared/data";
  const std::vector<RealView> views = RealViews(data / "bunny_turntable_36views", 3);
  if (views.empty()) GTEST_SKIP() << "no recorded views in " << data;
  Result<TriangleMesh> mesh = ImportMesh(data / "meshes/stanford_bunny.ply", 1.0);
  ASSERT_TRUE(mesh.ok());
  Result<ObjectModel> model =
      BuildObjectModel("bunny", std::move(mesh).value(), SymmetryGroup::None(), "scan", {});
  ASSERT_TRUE(model.ok());
  Result<std::unique_ptr<PoseEstimator>> estimator =
      CreatePpfEstimator(std::vector<ObjectModel>{*model}, {});
  ASSERT_TRUE(estimator.ok());
  CameraModel camera;
  camera.fx = 542.0;
  camera.fy = 540.5;
  camera.cx = 320.0;
  camera.cy = 240.0;
  std::vector<double> degrees;
  Rng rng(8);
  for (const RealView& view : views) {
    const PoseEstimator::Output output = (*estimator)->Estimate(view.depth, camera, rng);
    ASSERT_EQ(output.detections.size(), 1U);
    const Pose& T = output.detections[0].T_camera_object;
    degrees.push_back(GeodesicAngle(Eigen::Quaterniond(T.linear()), view.rotation) / kDegree);
    const Eigen::Vector3d center = view.rotation * model->center + view.translation;
    EXPECT_LT((T * model->center - center).norm(), 0.002);
    EXPECT_GT(output.detections[0].verification_score, 0.9);
  }
  std::sort(degrees.begin(), degrees.end());
  EXPECT_LT(degrees[degrees.size() / 2], 0.3);
  EXPECT_LT(degrees.back(), 2.0);
}

}  // namespace
}  // namespace vantage
