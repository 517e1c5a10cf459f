// The viewer's state from messages: what is kept, what is refused, what is forgotten.

#include "tools/viewer/viewer_state.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "bus/conversions.h"
#include "bus/image_conversion.h"
#include "bus/message_check.h"
#include "tests/tools/run_fixtures.h"
#include "tools/viewer/viewer_scene.h"
#include "tools/viewer/window_page.h"

namespace vantage {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

template <class Message>
void Apply(const std::string& channel, const Message& message, ViewerState* state) {
  state->Apply(channel, message.utime, Encode(message));
}

Pose At(double x, double y, double z) {
  Pose pose = Pose::Identity();
  pose.translation() = Eigen::Vector3d(x, y, z);
  return pose;
}

void ApplyPose(const Pose& T_world_camera, int64_t utime, ViewerState* state) {
  Apply("CAMERA_A_TO_WORLD", PoseToMessage(T_world_camera, utime), state);
}

CameraModel SmallCamera() {
  CameraModel camera;
  camera.width = 32;
  camera.height = 24;
  camera.fx = camera.fy = 30.0;
  camera.cx = 15.5;
  camera.cy = 11.5;
  return camera;
}

void ApplyInfo(ViewerState* state) {
  CameraIdentity identity;
  identity.name = "A";
  Apply("CAMERA_A_INFO", CameraToMessage(SmallCamera(), identity, kRunStart, 0), state);
}

void ApplyDepth(int64_t utime, int64_t seq, ViewerState* state) {
  const std::vector<uint16_t> millimetres(32 * 24, 1000);
  Apply("CAMERA_A",
        DepthToMessage(32, 24, millimetres, utime, seq, "", DepthCompression::kZlib),
        state);
}

// A camera that stands at a place for 0.6 s and takes an image in the middle.
void ApplyStop(const Pose& T_world_camera, int64_t utime, int64_t seq, ViewerState* state) {
  for (int i = -30; i <= 30; ++i) {
    if (i == 0) ApplyDepth(utime, seq, state);
    ApplyPose(T_world_camera, utime + 10'000 * i, state);
  }
}

next_view_t PlanOf(size_t count) {
  next_view_t plan{};
  plan.utime = kRunStart;
  plan.selected = -1;
  view_candidate_t candidate{};
  candidate.quat[0] = 1.0;
  candidate.reachable = 1;
  plan.candidates.assign(count, candidate);
  plan.num_candidates = static_cast<int32_t>(count);
  return plan;
}

TEST(ViewerState, CloudLiesWhereTheCameraStoodAtTheImage) {
  ViewerState state;
  ApplyInfo(&state);
  // The pose goes on changing after the stop: the image's own is what counts.
  ApplyStop(At(0.5, 0.0, 2.0), kRunStart, 0, &state);
  ApplyPose(At(9.0, 9.0, 9.0), kRunStart + 400'000, &state);
  ASSERT_EQ(state.cloud().chunks().size(), 1U);
  for (const CloudPoint& point : state.cloud().chunks()[0]->points) {
    EXPECT_NEAR(point.position.z(), 3.0, 1e-5);  // 1 m before the camera.
    EXPECT_NEAR(point.position.x(), 0.5, 0.6);
    EXPECT_NEAR(point.depth, 1.0, 1e-6);
  }
}

TEST(ViewerState, CloudTakesNothingInMotionAndNothingTwice) {
  ViewerState state;
  ApplyInfo(&state);
  for (int i = 0; i < 100; ++i) {
    if (i == 50) ApplyDepth(kRunStart + 500'000, 0, &state);
    ApplyPose(At(0.002 * i, 0.0, 2.0), kRunStart + 10'000 * i, &state);
  }
  EXPECT_EQ(state.cloud().num_points(), 0U);
  ApplyStop(At(0.5, 0.0, 2.0), kRunStart + 5'000'000, 1, &state);
  const size_t once = state.cloud().num_points();
  EXPECT_GT(once, 0U);
  ApplyStop(At(0.5, 0.0, 2.0), kRunStart + 6'000'000, 2, &state);
  EXPECT_EQ(state.cloud().num_points(), once);
}

TEST(SceneCloud, HoldsNoMorePointsThanAllowedAndOneAVoxel) {
  SceneCloud::Parameters parameters;
  parameters.voxel = 0.02;
  parameters.max_points = 900;
  SceneCloud cloud(parameters);
  const DepthImage depth(32, 24, 1.0F);
  for (int i = 0; i < 10; ++i) cloud.Add(depth, SmallCamera(), At(3.0 * i, 0.0, 0.0), {});
  EXPECT_LE(cloud.num_points(), 900U);
  EXPECT_GT(cloud.num_points(), 0U);
  // The newest image is there.
  EXPECT_NEAR(cloud.chunks().back()->points.front().position.x(), 27.0, 1.0);
  SceneCloud coarse({1.0, 1000, 4.0});
  coarse.Add(depth, SmallCamera(), At(0.5, 0.5, 0.5), {});
  EXPECT_LE(coarse.num_points(), 9U);
  // A pose far away or an image of another size adds nothing.
  cloud.Clear();
  cloud.Add(depth, SmallCamera(), At(1e6, 0.0, 0.0), {});
  cloud.Add(DepthImage(8, 8, 1.0F), SmallCamera(), Pose::Identity(), {});
  EXPECT_EQ(cloud.num_points(), 0U);
}

TEST(ViewerState, ObjectsThatVanishTakeTheirHistogramAlong) {
  ViewerState state;
  Apply("OBJECTS",
        ObjectsOf(
            {EstimateAt(1, "mug", At(0, 0, 0)), EstimateAt(2, "mug", At(1, 0, 0))}, 1, kRunStart),
        &state);
  orientation_histogram_t histogram{};
  histogram.utime = kRunStart;
  histogram.k = 16;
  for (const int32_t instance : {1, 2}) {
    histogram.instance_id = instance;
    Apply("ORIENTATION_HISTOGRAM", histogram, &state);
  }
  EXPECT_NE(state.histogram(2), nullptr);
  Apply("OBJECTS", ObjectsOf({EstimateAt(1, "mug", At(0, 0, 0))}, 2, kRunStart + 1), &state);
  EXPECT_EQ(state.objects().Find(2), nullptr);
  EXPECT_EQ(state.histogram(2), nullptr);
  EXPECT_NE(state.histogram(1), nullptr);
}

TEST(ViewerState, StepsStartAnewWithFusion) {
  ViewerState state;
  for (int view = 1; view <= 3; ++view) {
    Apply(
        "OBJECTS", ObjectsOf({EstimateAt(1, "mug", At(0, 0, 0))}, view, kRunStart + view), &state);
  }
  EXPECT_EQ(state.steps().size(), 3U);
  Apply("OBJECTS", ObjectsOf({EstimateAt(0, "mug", At(0, 0, 0))}, 1, kRunStart + 9), &state);
  ASSERT_EQ(state.steps().size(), 1U);
  EXPECT_EQ(state.steps()[0].viewpoint, 0);
}

TEST(ViewerState, StepNamesTheDetectionAndItsNearestPeak) {
  ViewerState state;
  DetectionSet set;
  set.utime = kRunStart;
  set.seq = 5;
  set.camera = "A";
  set.estimator = "ppf";
  set.T_world_camera = At(0.0, 0.0, 1.0);
  Detection detection;
  detection.model_id = "mug";
  detection.verification_score = 0.75;
  detection.T_camera_object = At(0.1, 0.0, -1.0);
  detection.T_camera_object.linear() =
      Eigen::AngleAxisd(80.0 * kDegree, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  set.detections = {detection};
  Apply("DETECTIONS_PPF", DetectionsToMessage(set), &state);
  object_estimate_v3_t object = EstimateAt(1, "mug", At(0, 0, 0));
  orientation_peak_v2_t second = object.peaks[0];
  second.quat[0] = second.quat[3] = std::sqrt(0.5);  // 90 degrees about z.
  second.weight = 0.25;
  object.peaks.push_back(second);
  object.num_peaks = 2;
  AddSource("DETECTIONS_PPF", 5, 0, 0, &object);
  Apply("OBJECTS", ObjectsOf({object}, 1, kRunStart), &state);
  const StepEntry& entry = state.steps().at(0).objects.at(1);
  ASSERT_TRUE(entry.detection);
  EXPECT_EQ(entry.nearest_peak, 1U);
  EXPECT_NEAR(entry.angle, 10.0 * kDegree, 1e-9);
  EXPECT_NEAR(entry.distance, 0.1, 1e-12);
  EXPECT_EQ(entry.score, 0.75);
  // A source that names no detection of that set is no detection.
  object.sources[0].index = 7;
  Apply("OBJECTS", ObjectsOf({object}, 2, kRunStart), &state);
  EXPECT_FALSE(state.steps().at(1).objects.at(1).detection);
}

TEST(ViewerState, CountsGapsInSeq) {
  ViewerState state;
  next_view_t plan = PlanOf(0);
  for (const int64_t seq : {0, 1, 5}) {
    plan.seq = seq;
    Apply("NEXT_VIEW", plan, &state);
  }
  EXPECT_EQ(state.num_lost(), 3);
}

TEST(ViewerState, RefusesWhatIsNotFinite) {
  ViewerState state;
  rigid_transform_t pose = PoseToMessage(At(0, 0, 0), kRunStart);
  pose.trans[1] = kNaN;
  Apply("CAMERA_A_TO_WORLD", pose, &state);
  EXPECT_EQ(state.num_refused(), 1);
  EXPECT_TRUE(state.cameras().empty());
  object_estimate_v3_t object = EstimateAt(1, "mug", At(0, 0, 0));
  object.peaks[0].quat[2] = kNaN;
  object_estimate_v3_t strange = EstimateAt(2, "../../etc", At(0, 0, 0));
  object_estimate_v3_t wide = EstimateAt(3, "mug", At(0, 0, 0));
  wide.trans_covariance[0] = std::numeric_limits<double>::infinity();
  wide.peaks[0].covariance[4] = kNaN;
  Apply("OBJECTS", ObjectsOf({object, strange, wide}, 1, kRunStart), &state);
  ASSERT_EQ(state.objects().objects.size(), 1U);
  EXPECT_EQ(state.objects().objects[0].instance, 3);
  EXPECT_EQ(state.objects().objects[0].position_covariance, Eigen::Matrix3d::Zero());
  next_view_t plan = PlanOf(3);
  plan.candidates[1].gain = kNaN;
  plan.candidates[2].trans[0] = 1e300;
  plan.selected = 1;
  Apply("NEXT_VIEW", plan, &state);
  EXPECT_EQ(state.plan().candidates.size(), 1U);
  EXPECT_FALSE(state.plan().chosen);
  // Nothing of it breaks the drawing.
  const ViewerScene scene = BuildScene(state, {}, {});
  for (const SceneMesh& mesh : scene.meshes) {
    for (const Eigen::Vector3f& vertex : mesh.mesh->vertices) EXPECT_TRUE(vertex.allFinite());
  }
}

TEST(ViewerState, BoundsWhatComesInMasses) {
  ViewerState state;
  next_view_t plan = PlanOf(1'000'000);
  plan.selected = 999'999;
  Apply("NEXT_VIEW", plan, &state);
  EXPECT_EQ(state.plan().candidates.size(), ViewerState::kMaxCandidates);
  EXPECT_EQ(state.plan().num_offered, 1'000'000U);
  EXPECT_TRUE(state.plan().chosen);
  std::vector<object_estimate_v3_t> objects;
  for (int i = 0; i < 1000; ++i) objects.push_back(EstimateAt(i, "mug", At(0, 0, 0)));
  Apply("OBJECTS", ObjectsOf(objects, std::numeric_limits<int32_t>::max(), kRunStart), &state);
  EXPECT_EQ(state.objects().objects.size(), ViewerState::kMaxObjects);
  for (int i = 0; i < 20'000; ++i) {
    ApplyPose(At(0.01 * (i % 100), 0.01 * (i / 100), 0.0), kRunStart + 10'000 * i, &state);
  }
  EXPECT_LE(state.cameras().at("A").path.size(), ViewerState::kMaxPath);
  for (int i = 0; i < 100; ++i) {
    Apply("CAMERA_N" + std::to_string(i) + "_TO_WORLD",
          PoseToMessage(At(0, 0, 0), kRunStart),
          &state);
  }
  EXPECT_LE(state.cameras().size(), ViewerState::kMaxCameras);
}

TEST(ViewerState, ALogThatBeginsAgainForgetsPathAndCloud) {
  ViewerState state;
  ApplyInfo(&state);
  ApplyStop(At(0.5, 0.0, 2.0), kRunStart + 60'000'000, 0, &state);
  EXPECT_GT(state.cloud().num_points(), 0U);
  ApplyPose(At(0.0, 0.0, 1.0), kRunStart, &state);
  EXPECT_EQ(state.cloud().num_points(), 0U);
  EXPECT_EQ(state.cameras().at("A").path.size(), 1U);
}

TEST(ViewerState, BytesOfAnotherKindAreCounted) {
  ViewerState state;
  const std::vector<std::byte> garbage(37, std::byte{0x5a});
  for (const char* channel : {"OBJECTS",
                              "NEXT_VIEW",
                              "CAMERA_A",
                              "CAMERA_A_TO_WORLD",
                              "DETECTIONS_X",
                              "ORIENTATION_HISTOGRAM",
                              "PROCESS_STATUS"}) {
    state.Apply(channel, kRunStart, garbage);
  }
  EXPECT_EQ(state.num_refused(), 7);
  state.Apply("SOMETHING_ELSE", kRunStart, garbage);
  state.Apply("CAMERA_", kRunStart, garbage);
  EXPECT_EQ(state.num_refused(), 7);
  EXPECT_EQ(state.num_used(), 0);
}

TEST(ViewerScene, ModelAtItsEstimateAndAnUnknownOneAsAName) {
  auto model = std::make_shared<ObjectModel>(PlainModel("mug", {0.0, 0.0, 0.05}, 0.1));
  model->mesh.vertices = {{0, 0, 0}, {0.1F, 0, 0}, {0, 0.1F, 0}};
  model->mesh.triangles = {{0, 1, 2}};
  ViewerState state;
  object_estimate_v3_t known = EstimateAt(4, "mug", At(0.1, 0.2, 0.3));
  known.peaks.push_back(known.peaks[0]);
  known.peaks[1].quat[0] = 0.0;
  known.peaks[1].quat[3] = 1.0;
  known.peaks[1].weight = 0.3;
  known.num_peaks = 2;
  Apply("OBJECTS", ObjectsOf({known, EstimateAt(5, "vase", At(1, 0, 0))}, 1, kRunStart), &state);
  const ViewerScene scene = BuildScene(state, {{"mug", model}}, {});
  ASSERT_EQ(scene.meshes.size(), 2U);  // The estimate, and the other peak.
  EXPECT_TRUE(scene.meshes[0].T_world_mesh.isApprox(At(0.1, 0.2, 0.3)));
  EXPECT_EQ(scene.meshes[0].opacity, 1.0);
  EXPECT_LT(scene.meshes[1].opacity, 0.5);
  // Turned about the model's center, which stays.
  EXPECT_TRUE((scene.meshes[1].T_world_mesh * model->center)
                  .isApprox(scene.meshes[0].T_world_mesh * model->center));
  bool is_named = false;
  for (const SceneLabel& label : scene.labels) is_named |= label.text == "5 vase (no model)";
  EXPECT_TRUE(is_named);
}

TEST(ViewerScene, EllipsoidAndConeAsWideAsTheirDeviations) {
  const Eigen::Matrix3d covariance =
      Eigen::Vector3d(1e-6, 4e-6, 9e-6).asDiagonal();  // 1, 2, 3 mm or mrad
  const TriangleMesh ellipsoid = EllipsoidMesh(Eigen::Vector3d::Zero(), covariance, 10.0);
  const Eigen::Vector3f size = ellipsoid.Bounds().sizes();
  EXPECT_NEAR(size.x(), 0.02, 1e-4);
  EXPECT_NEAR(size.y(), 0.04, 1e-4);
  EXPECT_NEAR(size.z(), 0.06, 1e-4);
  // The tip of an arm along x goes along y by turns about z, and along z by those about y.
  const TriangleMesh cone = AxisConeMesh(Eigen::Vector3d::Zero(), {2.0, 0.0, 0.0}, covariance, 1.0);
  EXPECT_NEAR(cone.Bounds().sizes().y(), 2 * 2.0 * 0.003, 1e-4);
  EXPECT_NEAR(cone.Bounds().sizes().z(), 2 * 2.0 * 0.002, 1e-4);
}

TEST(WindowPage, TextsLieInTheWindowWhateverTheState) {
  ViewerState state;
  std::vector<object_estimate_v3_t> objects;
  for (int i = 0; i < 40; ++i) objects.push_back(EstimateAt(i, "mug", At(0, 0, 0)));
  for (int view = 1; view < 60; ++view) {
    Apply("OBJECTS", ObjectsOf(objects, view, kRunStart + view), &state);
  }
  next_view_t plan = PlanOf(5);
  plan.reason = std::string(5000, 'x') + "\x1b[2J";
  Apply("NEXT_VIEW", plan, &state);
  for (const auto& [width, height] :
       {std::pair{WindowLayout::kLeastWidth, WindowLayout::kLeastHeight}, {1600, 900}}) {
    PageDrawer drawer;
    const ViewerScene scene = BuildScene(state, {}, {});
    const Page page =
        drawer.Draw(state, scene, {}, {kRunStart, kRunStart + 100, kRunStart}, {}, width, height);
    EXPECT_EQ(page.image.width, width);
    for (const PageText& text : page.texts) {
      EXPECT_GE(text.y, 0.0) << text.text;
      EXPECT_LE(text.y, height) << text.text;
      EXPECT_LE(text.x, width) << text.text;
      if (text.side == TextSide::kLeft && !text.text.empty()) {
        const bool is_left = text.x < LayOut(width, height).scene.right();
        const int end = is_left && text.y > 30.0 ? LayOut(width, height).scene.right() : width;
        EXPECT_LE(text.x + TextWidth(text), end) << text.text;
      }
      EXPECT_EQ(text.text.find('\x1b'), std::string::npos);
    }
  }
}

}  // namespace
}  // namespace vantage
