#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <set>

#include "tools/evaluate/simulated_sequence.h"
#include "tools/evaluate/simulated_views.h"

namespace vantage {
namespace {

constexpr double kNearest = 0.4;

// `size` times the bundled one.
ObjectModel Duck(double size) {
  Result<ObjectModel> model =
      LoadObjectModel(std::filesystem::path(VANTAGE_SOURCE_DIR) / "models/duck");
  EXPECT_TRUE(model.ok());
  for (Eigen::Vector3f& vertex : model->mesh.vertices) vertex *= static_cast<float>(size);
  model->center *= size;
  model->diameter *= size;
  return std::move(model).value();
}

SimulatedViews MakeViews(const ObjectModel& model, SequenceKind kind, int index) {
  Rng rng(SequenceSeed(1, model.id, kind, index));
  return MakeSimulatedViews(model, kind, index, {}, CameraModel{}, kNearest, rng);
}

double LowestVertex(const ObjectModel& model, const Pose& T_world_object) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3f& vertex : model.mesh.vertices) {
    lowest = std::min(lowest, (T_world_object * vertex.cast<double>()).z());
  }
  return lowest;
}

TEST(SimulatedViews, CircleIsThePapers) {
  const ObjectModel duck = Duck(1.0);
  const SimulatedViews views = MakeViews(duck, SequenceKind::kCircle, 0);
  ASSERT_EQ(views.T_world_camera.size(), 30U);
  EXPECT_EQ(views.scale, 1.0);
  const Eigen::Vector3d center = views.T_world_object * duck.center;
  const CameraModel camera;
  for (size_t i = 0; i < 30; ++i) {
    const Pose& T = views.T_world_camera[i];
    const Eigen::Vector3d to_camera = T.translation() - center;
    EXPECT_NEAR(to_camera.norm(), 0.75, 1e-12);
    EXPECT_NEAR(std::asin(to_camera.z() / to_camera.norm()), 45.0 * kDegree, 1e-12);
    const Eigen::Vector2d pixel = camera.Project(T.inverse() * center);
    EXPECT_NEAR(pixel.x(), camera.cx, 1e-9);
    EXPECT_NEAR(pixel.y(), camera.cy, 1e-9);
    EXPECT_NEAR(T.linear()(2, 0), 0.0, 1e-12);  // Upright.
    const Eigen::Vector3d next = views.T_world_camera[(i + 1) % 30].translation() - center;
    const double turn = std::atan2(to_camera.x() * next.y() - to_camera.y() * next.x(),
                                   to_camera.head<2>().dot(next.head<2>()));
    EXPECT_NEAR(turn, 12.0 * kDegree, 1e-12);
  }
}

TEST(SimulatedViews, ShowTheWholeObjectOnTheTable) {
  const CameraModel camera;
  for (const double size : {1.0, 4.0}) {
    const ObjectModel duck = Duck(size);
    for (int index = 0; index < 40; ++index) {
      for (const SequenceKind kind : {SequenceKind::kCircle, SequenceKind::kRandom}) {
        const SimulatedViews views = MakeViews(duck, kind, index);
        EXPECT_EQ(views.scale > 1.0, size > 1.0);
        EXPECT_NEAR(LowestVertex(duck, views.T_world_object), 0.0, 1e-9);
        for (const Pose& T_world_camera : views.T_world_camera) {
          EXPECT_GT(T_world_camera.translation().z(), 0.0);
          const Pose T_camera_object = T_world_camera.inverse() * views.T_world_object;
          for (const Eigen::Vector3f& vertex : duck.mesh.vertices) {
            const Eigen::Vector3d p_camera = T_camera_object * vertex.cast<double>();
            ASSERT_GT(p_camera.z(), kNearest);
            const Eigen::Vector2d pixel = camera.Project(p_camera);
            ASSERT_TRUE(pixel.x() > 0.0 && pixel.x() < 639.0) << pixel.x();
            ASSERT_TRUE(pixel.y() > 0.0 && pixel.y() < 479.0) << pixel.y();
          }
        }
      }
    }
  }
}

TEST(SimulatedViews, RandomOnesFillTheirRanges) {
  const ObjectModel duck = Duck(1.0);
  const SimulatedViewParameters limits;
  double lowest = 90.0;
  double highest = 0.0;
  double nearest = 10.0;
  double farthest = 0.0;
  double off_axis = 0.0;
  Eigen::Vector3d azimuths = Eigen::Vector3d::Zero();
  Eigen::Vector2d rolls = Eigen::Vector2d::Zero();
  constexpr int kSequences = 100;
  for (int index = 0; index < kSequences; ++index) {
    const SimulatedViews views = MakeViews(duck, SequenceKind::kRandom, index);
    ASSERT_EQ(views.T_world_camera.size(), 12U);
    const Eigen::Vector3d center = views.T_world_object * duck.center;
    EXPECT_NEAR(center.x(), 0.0, 1e-12);
    EXPECT_NEAR(center.y(), 0.0, 1e-12);
    const double tilt = std::acos(std::min(1.0, views.T_world_object.linear()(2, 2)));
    EXPECT_EQ(tilt < 1e-6, index % 2 == 0);
    for (const Pose& T : views.T_world_camera) {
      const Eigen::Vector3d to_camera = T.translation() - center;
      const double elevation = std::asin(to_camera.z() / to_camera.norm()) / kDegree;
      lowest = std::min(lowest, elevation);
      highest = std::max(highest, elevation);
      nearest = std::min(nearest, to_camera.norm());
      farthest = std::max(farthest, to_camera.norm());
      off_axis = std::max(off_axis, (T.inverse() * center).head<2>().norm());
      azimuths += Eigen::Vector3d(to_camera.x(), to_camera.y(), 0.0).normalized();
      rolls += Eigen::Vector2d(T.linear()(2, 0), T.linear()(2, 1)).normalized();
    }
  }
  EXPECT_GE(lowest, limits.lowest_elevation_deg);
  EXPECT_LE(highest, limits.highest_elevation_deg);
  EXPECT_GT(highest - lowest, 54.0);
  EXPECT_GE(nearest, limits.nearest_distance);
  EXPECT_LE(farthest, limits.farthest_distance);
  EXPECT_GT(farthest - nearest, 0.295);
  EXPECT_GT(off_axis, 0.03);
  EXPECT_LE(off_axis, std::sqrt(3.0) * limits.aim_jitter);
  // Means of 1200 unit vectors: a fifth of this is one standard deviation.
  EXPECT_LT(azimuths.norm() / 1200.0, 0.14);
  EXPECT_LT(rolls.norm() / 1200.0, 0.14);
}

TEST(SimulatedViews, RefuseParametersOutOfRange) {
  EXPECT_TRUE(SimulatedViewParameters{}.Validate().ok());
  EXPECT_FALSE((SimulatedViewParameters{.circle_views = 0}.Validate().ok()));
  SimulatedViewParameters parameters;
  parameters.farthest_distance = 0.5;
  const Result<void> valid = parameters.Validate();
  ASSERT_FALSE(valid.ok());
  EXPECT_NE(valid.error().message.find("farthest_distance = 0.5"), std::string::npos);
}

TEST(SequenceSeed, IsEverySequencesOwn) {
  std::set<uint64_t> seeds;
  int count = 0;
  for (const uint64_t seed : {1U, 2U, 11U}) {
    for (const char* model : {"duck", "mug", "1"}) {
      for (const SequenceKind kind : {SequenceKind::kCircle, SequenceKind::kRandom}) {
        for (int index = 0; index < 200; ++index, ++count) {
          seeds.insert(SequenceSeed(seed, model, kind, index));
        }
      }
    }
  }
  EXPECT_EQ(seeds.size(), static_cast<size_t>(count));
}

TEST(SequenceSimulator, MakesAnySequenceAlone) {
  const ObjectModel duck = Duck(1.0);
  SimulationParameters parameters;
  parameters.views.random_views = 2;
  const auto first = SequenceSimulator::Create(duck, parameters).value();
  const auto second = SequenceSimulator::Create(duck, parameters).value();
  first->Simulate(SequenceKind::kRandom, 0);
  const DetectionSequence after = first->Simulate(SequenceKind::kRandom, 1);
  const DetectionSequence alone = second->Simulate(SequenceKind::kRandom, 1);
  EXPECT_EQ(after.T_world_object.matrix(), alone.T_world_object.matrix());
  ASSERT_EQ(after.views.size(), 2U);
  for (size_t view = 0; view < 2; ++view) {
    const DetectedView& a = after.views[view];
    const DetectedView& b = alone.views[view];
    EXPECT_EQ(a.T_world_camera.matrix(), b.T_world_camera.matrix());
    ASSERT_EQ(a.detections.size(), b.detections.size());
    ASSERT_FALSE(a.detections.empty());
    for (size_t i = 0; i < a.detections.size(); ++i) {
      EXPECT_EQ(a.detections[i].T_camera_object.matrix(), b.detections[i].T_camera_object.matrix());
      EXPECT_EQ(a.detections[i].verification_score, b.detections[i].verification_score);
    }
  }
}

}  // namespace
}  // namespace vantage
