#include "nodes/fusion_node.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "bus/conversions.h"
#include "common/format.h"
#include "common/rng.h"
#include "common/time_range.h"
#include "nodes/fusion_messages.h"
#include "tests/nodes/fusion_test_bus.h"
#include "tests/perception/test_scenes.h"
#include "vantage/arm_status_t.hpp"

namespace vantage {
namespace {

const Eigen::Vector3d kCenter(0.01, 0.0, 0.04);  // m, of every model
const Eigen::Vector3d kTarget(0.0, 0.0, 0.05);

FusionConfig MakeConfig() {
  FusionConfig config;
  config.k = 32;
  config.views.candidates.target = kTarget;
  config.models["mug"] = {kCenter, 0.12};
  config.models["filter"] = {kCenter, 0.10};
  config.shapes["mug"] = {MakeBox({-0.02F, -0.02F, 0.0F}, {0.04F, 0.02F, 0.08F}), 0.06};
  config.shapes["filter"] = {MakeBox({-0.02F, -0.02F, 0.01F}, {0.04F, 0.02F, 0.07F}), 0.05};
  config.setup = "mug filter";
  return config;
}

Pose At(double x, double y, double yaw_deg) {
  Pose pose = Pose::Identity();
  pose.linear() = ExpSo3(Eigen::Vector3d(0.1, 0.2, yaw_deg * kDegree)).toRotationMatrix();
  pose.translation() = Eigen::Vector3d(x, y, 0.0);
  return pose;
}

/// A robot, a camera, an estimator and two objects: answers what the node publishes. Its clock is
/// the message time, 100 ms a frame.
class World {
 public:
  explicit World(TestBus& bus) : bus_(bus), rng_(3) {
    truth_ = {{"mug", At(-0.1, 0.05, 40.0)}, {"filter", At(0.12, 0.0, 200.0)}};
    T_world_camera_ = LookAt(Eigen::Vector3d(0.0, -0.53, 0.58), kTarget);
  }

  // One frame: pose, detections; then the robot goes where it was told last.
  void Frame() {
    utime_ += 100'000;
    bus_.Send("CAMERA_XTION_TO_WORLD", PoseToMessage(T_world_camera_, utime_));
    DetectionSet set;
    set.utime = utime_;
    set.seq = seq_++;
    set.image_seq = set.seq;
    set.camera = "XTION";
    set.estimator = "ppf";
    set.T_world_camera = T_world_camera_;
    for (const auto& [model, T_world_object] : truth_) {
      Detection detection;
      detection.model_id = model;
      detection.cluster = set.num_clusters++;
      Pose error = Pose::Identity();
      error.linear() = ExpSo3(RotationError(T_world_object)).toRotationMatrix();
      error.translation() = 0.0005 * Noise() + kCenter - error.linear() * kCenter;
      detection.T_camera_object = T_world_camera_.inverse() * T_world_object * error;
      detection.mse = 1e-6;
      detection.inlier_fraction = 0.9;
      detection.verification_score = rng_.Uniform(0.7, 0.95);
      set.detections.push_back(detection);
    }
    last_ = DetectionsToMessage(set);
    bus_.Send("DETECTIONS_PPF", last_);
    FollowNextView();
  }

  void Status(int8_t state, int64_t view_seq, const std::string& reason = "") {
    arm_status_t status{};
    status.utime = utime_;
    status.name = "XTION";
    status.state = state;
    status.view_seq = view_seq;
    status.reason = reason;
    bus_.Send("ARM_STATUS", status);
  }

  void FollowNextView() {
    if (!hears_ || bus_.Count("NEXT_VIEW") == 0) return;
    const next_view_t view = bus_.Last<next_view_t>("NEXT_VIEW");
    if (view.seq == view_seq_) return;
    view_seq_ = view.seq;
    if (view.selected < 0) return;
    ASSERT_LT(view.selected, view.num_candidates);
    const view_candidate_t& candidate = view.candidates[static_cast<size_t>(view.selected)];
    selected_.push_back(view.selected);
    const Result<Pose> pose = PoseFromWire(std::span<const double, 3>(candidate.trans),
                                           std::span<const double, 4>(candidate.quat));
    ASSERT_TRUE(pose.ok());
    utime_ += 2'000'000;
    T_world_camera_ = *pose;
    Status(arm_status_t::RESTING, view_seq_);
  }

  // Frames until the node says that it has finished.
  void RunToTheEnd(int most_frames = 200) {
    for (int i = 0; i < most_frames && !Finished(); ++i) Frame();
  }
  bool Finished() const {
    return bus_.Count("OBJECTS") > 0 && bus_.Last<object_estimates_v3_t>("OBJECTS").finished != 0;
  }

  void ExpectObjectsFound(double angle_deg, double distance_m) const {
    const object_estimates_v3_t objects = bus_.Last<object_estimates_v3_t>("OBJECTS");
    ASSERT_EQ(objects.num_objects, static_cast<int32_t>(truth_.size()));
    for (const object_estimate_v3_t& object : objects.objects) {
      EXPECT_EQ(object.state, object_estimate_v3_t::CONFIRMED);
      const Pose& truth = truth_.at(object.model_id);
      const Eigen::Vector3d trans(object.trans);
      EXPECT_LT((trans - truth.translation()).norm(), distance_m);
      const double* quat = object.peaks.front().quat;
      const Eigen::Quaterniond q(quat[0], quat[1], quat[2], quat[3]);
      EXPECT_LT(GeodesicAngle(q, Eigen::Quaterniond(truth.linear())) / kDegree, angle_deg);
    }
  }

  // rad, in the object's frame.
  Eigen::Vector3d RotationError(const Pose& T_world_object) {
    if (error_axis_.isZero()) return 0.5 * kDegree * Noise();
    return T_world_object.linear().transpose() * error_axis_ * (kDegree * rng_.Normal());
  }
  Eigen::Vector3d Noise() { return {rng_.Normal(), rng_.Normal(), rng_.Normal()}; }

  TestBus& bus_;
  Rng rng_;
  std::map<std::string, Pose> truth_;
  Pose T_world_camera_;
  detections_v2_t last_{};
  int64_t utime_ = 1'700'000'000'000'000;
  int64_t seq_ = 0;
  int64_t view_seq_ = -1;
  bool hears_ = true;  // The robot, what it is told.
  std::vector<int> selected_;
  Eigen::Vector3d error_axis_ = Eigen::Vector3d::Zero();  // In the world; 0: any.
};

std::unique_ptr<Node> MustMake(TestBus& bus, const FusionConfig& config, bool fresh = false) {
  Result<std::unique_ptr<Node>> node = MakeFusionNode(bus, config, fresh);
  VANTAGE_CHECK(node.ok(), node.error().message);
  return std::move(*node);
}

/// A folder of its own for every test, removed after it.
class FusionNodeTest : public testing::Test {
 protected:
  void SetUp() override {
    const testing::TestInfo* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() /
              Format("vantage_fusion_%s_%d", info->name(), static_cast<int>(getpid()));
    std::filesystem::remove_all(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  FusionConfig ConfigWithState() const {
    FusionConfig config = MakeConfig();
    config.state_file = folder_ / "sub" / "fusion.state";
    return config;
  }

  std::filesystem::path folder_;
};

TEST_F(FusionNodeTest, LeadsFromViewToViewUntilAllIsKnown) {
  TestBus bus;
  const std::unique_ptr<Node> node = MustMake(bus, MakeConfig());
  World world(bus);
  world.RunToTheEnd();
  ASSERT_TRUE(world.Finished());
  world.ExpectObjectsFound(2.0, 0.003);
  const next_view_t last = bus.Last<next_view_t>("NEXT_VIEW");
  EXPECT_EQ(last.selected, -1);
  EXPECT_FALSE(last.reason.empty());
  const object_estimates_v3_t objects = bus.Last<object_estimates_v3_t>("OBJECTS");
  EXPECT_GE(objects.num_viewpoints, 4);
  EXPECT_LE(objects.num_viewpoints, MakeConfig().views.max_views);
  // Two frames a view, and no view twice.
  EXPECT_EQ(world.seq_, 2 * objects.num_viewpoints);
  const std::set<int> distinct(world.selected_.begin(), world.selected_.end());
  EXPECT_EQ(distinct.size(), world.selected_.size());
  for (const object_estimate_v3_t& object : objects.objects) {
    EXPECT_EQ(object.num_sources, object.num_views);
    for (const detection_source_t& source : object.sources) {
      EXPECT_EQ(source.channel, "DETECTIONS_PPF");
      EXPECT_EQ(source.seq / 2, source.viewpoint);
    }
  }
  EXPECT_EQ(bus.state(), "ok");
}

TEST_F(FusionNodeTest, EndsAfterMaxViews) {
  FusionConfig config = MakeConfig();
  config.tracker.orientation.converge_angle = 1e-6;
  config.views.max_views = 6;
  TestBus bus;
  const std::unique_ptr<Node> node = MustMake(bus, config);
  World world(bus);
  world.RunToTheEnd();
  EXPECT_TRUE(world.Finished());
  EXPECT_EQ(bus.Last<object_estimates_v3_t>("OBJECTS").num_viewpoints, 6);
  EXPECT_EQ(world.selected_.size(), 5U);
  // It goes on fusing, without leading anywhere.
  world.Frame();
  EXPECT_EQ(bus.Last<next_view_t>("NEXT_VIEW").seq, world.view_seq_);
}

TEST_F(FusionNodeTest, SaysNothingBeforeThereAreDetections) {
  TestBus bus;
  const std::unique_ptr<Node> node = MustMake(bus, MakeConfig());
  for (int i = 0; i < 50; ++i) {
    bus.Send("CAMERA_XTION_TO_WORLD", PoseToMessage(Pose::Identity(), 100'000 * i));
  }
  EXPECT_TRUE(bus.published().empty());
}

TEST_F(FusionNodeTest, RepeatsTheNextViewEverySecondOfMessageTime) {
  TestBus bus;
  const std::unique_ptr<Node> node = MustMake(bus, MakeConfig());
  World world(bus);
  world.Frame();
  EXPECT_EQ(bus.Count("NEXT_VIEW"), 0U);
  world.Frame();
  const int64_t start = world.utime_;  // When the robot arrived, and the view was told again.
  ASSERT_EQ(bus.Count("NEXT_VIEW"), 2U);
  bus.ForgetPublished();
  for (int i = 1; i <= 350; ++i) {
    bus.Send("CAMERA_XTION_TO_WORLD", PoseToMessage(Pose::Identity(), start + 10'000 * i));
  }
  EXPECT_EQ(bus.Count("NEXT_VIEW"), 3U);
  for (const next_view_t& view : bus.Published<next_view_t>("NEXT_VIEW"))
    EXPECT_EQ(view.seq, world.view_seq_);
  // The clock was set back: once more, at once.
  bus.Send("CAMERA_XTION_TO_WORLD", PoseToMessage(Pose::Identity(), start - 60'000'000));
  EXPECT_EQ(bus.Count("NEXT_VIEW"), 4U);
}

TEST_F(FusionNodeTest, ARefusedViewIsReplacedAndNotProposedAgain) {
  TestBus bus;
  const std::unique_ptr<Node> node = MustMake(bus, MakeConfig());
  World world(bus);
  world.Frame();
  world.Frame();
  std::set<int> refused;
  next_view_t view = bus.Last<next_view_t>("NEXT_VIEW");
  for (int i = 0; i < 10; ++i) {
    refused.insert(view.selected);
    world.Status(arm_status_t::REFUSED, view.seq, "joint 3 at its limit");
    world.Status(arm_status_t::REFUSED, view.seq, "joint 3 at its limit");
    const next_view_t next = bus.Last<next_view_t>("NEXT_VIEW");
    EXPECT_EQ(next.seq, view.seq + 1);
    const view_candidate_t& old = next.candidates[static_cast<size_t>(view.selected)];
    EXPECT_EQ(old.reachable, 0);
    EXPECT_EQ(old.reason, "joint 3 at its limit");
    EXPECT_FALSE(refused.contains(next.selected));
    view = next;
  }
  // All the others, too.
  while (view.selected >= 0) {
    world.Status(arm_status_t::REFUSED, view.seq, "too far");
    view = bus.Last<next_view_t>("NEXT_VIEW");
  }
  EXPECT_TRUE(world.Finished());
}

TEST_F(FusionNodeTest, ADuplicateChangesNothing) {
  TestBus bus;
  const std::unique_ptr<Node> node = MustMake(bus, MakeConfig());
  World world(bus);
  world.Frame();
  const size_t count = bus.published().size();
  bus.Send("DETECTIONS_PPF", world.last_);
  EXPECT_EQ(bus.published().size(), count);
}

TEST_F(FusionNodeTest, ARefusedTableIsToldAsLongAsItRuns) {
  TestBus bus;
  FusionConfig config = MakeConfig();
  config.refused_tables["mug"] = "mug.bin is of another estimator";
  const std::unique_ptr<Node> node = MustMake(bus, config);
  World world(bus);
  world.Frame();
  EXPECT_GT(bus.Count("OBJECTS"), 0U);
  EXPECT_NE(bus.state().find("mug.bin is of another estimator"), std::string::npos) << bus.state();
  EXPECT_NE(bus.state().find("by confidence alone"), std::string::npos) << bus.state();
}

TEST_F(FusionNodeTest, ABadSetIsDroppedAndReported) {
  TestBus bus;
  const std::unique_ptr<Node> node = MustMake(bus, MakeConfig());
  World world(bus);
  world.Frame();
  const size_t count = bus.Count("OBJECTS");
  detections_v2_t bad = world.last_;
  bad.seq += 1;
  bad.camera_quat[0] = 7.0;
  bus.Send("DETECTIONS_PPF", bad);
  EXPECT_EQ(bus.Count("OBJECTS"), count);
  EXPECT_NE(bus.state().find("quaternion"), std::string::npos) << bus.state();
  bad = world.last_;
  bad.seq += 2;
  bad.detections.front().model_id = "teapot";
  bus.Send("DETECTIONS_PPF", bad);
  EXPECT_EQ(bus.Last<object_estimates_v3_t>("OBJECTS").num_objects, 2);
  EXPECT_NE(bus.state().find("not in use"), std::string::npos) << bus.state();
  // Told until all is well again.
  world.Frame();
  EXPECT_EQ(bus.state(), "ok");
}

TEST_F(FusionNodeTest, AFailedSaveIsToldUntilOneSucceeds) {
  const FusionConfig config = ConfigWithState();
  TestBus bus;
  const std::unique_ptr<Node> node = MustMake(bus, config);
  World world(bus);
  // Not even root can write into a folder that is none.
  const std::filesystem::path folder = config.state_file.parent_path();
  std::filesystem::remove_all(folder);
  std::ofstream(folder) << "a file";
  world.Frame();
  EXPECT_NE(bus.state().find("can't write the state file"), std::string::npos) << bus.state();
  // A bad set and its end leave that as it is.
  detections_v2_t bad = world.last_;
  bad.camera_quat[0] = 7.0;
  bus.Send("DETECTIONS_PPF", bad);
  EXPECT_NE(bus.state().find("quaternion"), std::string::npos) << bus.state();
  bus.Send("DETECTIONS_PPF", world.last_);
  EXPECT_EQ(bus.state().find("quaternion"), std::string::npos) << bus.state();
  EXPECT_NE(bus.state().find("can't write the state file"), std::string::npos) << bus.state();
  std::filesystem::remove(folder);
  std::filesystem::create_directories(folder);
  world.Frame();
  EXPECT_EQ(bus.state(), "ok");
}

TEST_F(FusionNodeTest, TimesThatCantBeAreDroppedAndReported) {
  for (const int64_t utime : {INT64_MIN, int64_t{-1}, kLatestUtime + 1, INT64_MAX}) {
    TestBus bus;
    const std::unique_ptr<Node> node = MustMake(bus, MakeConfig());
    World world(bus);
    world.Frame();
    world.Frame();
    const int64_t now = world.utime_;
    ASSERT_EQ(bus.state(), "ok");
    const size_t count = bus.published().size();
    world.utime_ = utime;
    world.Status(arm_status_t::MOVING, 0);
    EXPECT_NE(bus.state().find("ARM_STATUS has the utime"), std::string::npos) << bus.state();
    bus.Send("CAMERA_XTION_TO_WORLD", PoseToMessage(Pose::Identity(), utime));
    EXPECT_NE(bus.state().find("_TO_WORLD has the utime"), std::string::npos) << bus.state();
    detections_v2_t set = world.last_;
    set.utime = utime;
    set.seq += 1;
    bus.Send("DETECTIONS_PPF", set);
    EXPECT_EQ(bus.published().size(), count);
    world.utime_ = now;
    world.Frame();
    EXPECT_EQ(bus.state(), "ok");
  }
}

// Without a state a node that is started again knows nothing, but the robot still says that it
// rests at the view of the last decision it heard.
TEST_F(FusionNodeTest, WhatTheRobotSaysOfAnEarlierLifeIsNoArrival) {
  TestBus bus;
  std::unique_ptr<Node> node = MustMake(bus, MakeConfig());
  World world(bus);
  world.Frame();
  world.Frame();
  const int64_t old_seq = world.view_seq_;
  bus.Reset();
  node = MustMake(bus, MakeConfig());
  world.hears_ = false;
  world.Frame();
  world.Frame();
  const next_view_t decided = bus.Last<next_view_t>("NEXT_VIEW");
  for (int i = 0; i < 5; ++i) {
    world.Status(arm_status_t::RESTING, old_seq);
    world.Frame();
  }
  const next_view_t last = bus.Last<next_view_t>("NEXT_VIEW");
  EXPECT_EQ(last.seq, decided.seq);
  EXPECT_EQ(last.selected, decided.selected);
}

TEST_F(FusionNodeTest, TheHistogramFitsInAMessage) {
  FusionConfig config = MakeConfig();
  config.tracker.orientation.sigma_cw = 15.0 * kDegree;
  TestBus bus;
  const std::unique_ptr<Node> node = MustMake(bus, config);
  World world(bus);
  for (int i = 0; i < 6; ++i) world.Frame();
  const auto histogram = bus.Last<orientation_histogram_t>("ORIENTATION_HISTOGRAM");
  EXPECT_EQ(histogram.num_cells, static_cast<int32_t>(kMostCells));
  EXPECT_LT(histogram.getEncodedSize(), 64'000);
  EXPECT_TRUE(std::is_sorted(histogram.cell.begin(), histogram.cell.end()));
  EXPECT_GT(*std::min_element(histogram.weight.begin(), histogram.weight.end()), 0.0F);
}

// The same messages through one node, and through nodes that are ended and started in between.
void ExpectGoesOnExactly(const FusionConfig& config, const std::filesystem::path& state_file) {
  FusionConfig with_state = config;
  with_state.state_file = state_file;
  TestBus whole_bus;
  const std::unique_ptr<Node> whole = MustMake(whole_bus, config);
  World whole_world(whole_bus);
  whole_world.RunToTheEnd();

  TestBus bus;
  std::unique_ptr<Node> node = MustMake(bus, with_state);
  World world(bus);
  for (int i = 0; i < 200 && !world.Finished(); ++i) {
    world.Frame();
    if (i % 3 != 1) continue;
    bus.Reset();
    node = MustMake(bus, with_state);
    bus.Send("CAMERA_XTION_TO_WORLD", PoseToMessage(world.T_world_camera_, world.utime_));
    ASSERT_EQ(bus.Count("OBJECTS"), 1U) << i;
    ASSERT_EQ(bus.Last<next_view_t>("NEXT_VIEW").seq, world.view_seq_) << i;
  }
  EXPECT_EQ(world.selected_, whole_world.selected_);
  EXPECT_EQ(world.seq_, whole_world.seq_);
  object_estimates_v3_t a = bus.Last<object_estimates_v3_t>("OBJECTS");
  object_estimates_v3_t b = whole_bus.Last<object_estimates_v3_t>("OBJECTS");
  a.seq = b.seq = 0;
  EXPECT_EQ(Encode(a), Encode(b));
}

TEST_F(FusionNodeTest, GoesOnFromItsStateExactly) {
  ExpectGoesOnExactly(MakeConfig(), ConfigWithState().state_file);
}

TEST_F(FusionNodeTest, GoesOnFromItsStateExactlyWithAPriorSymmetryAndMotion) {
  FusionConfig config = MakeConfig();
  config.tracker.orientation.sigma_motion = 0.5 * kDegree;
  config.models["mug"].symmetry = SymmetryGroup::Continuous(Eigen::Vector3d::UnitZ(), false);
  config.models["mug"].likely_poses = {
      {Eigen::Quaterniond(At(0.0, 0.0, 10.0).linear()), 10.0 * kDegree, 1.0}};
  config.models["filter"].symmetry = SymmetryGroup::Cyclic(3, Eigen::Vector3d::UnitZ());
  ExpectGoesOnExactly(config, ConfigWithState().state_file);
}

TEST_F(FusionNodeTest, FreshForgetsTheState) {
  const FusionConfig config = ConfigWithState();
  TestBus bus;
  std::unique_ptr<Node> node = MustMake(bus, config);
  World world(bus);
  world.Frame();
  ASSERT_TRUE(std::filesystem::exists(config.state_file));
  TestBus again;
  node = MustMake(again, config, true);
  EXPECT_FALSE(std::filesystem::exists(config.state_file));
  again.Send("CAMERA_XTION_TO_WORLD", PoseToMessage(Pose::Identity(), world.utime_));
  EXPECT_TRUE(again.published().empty());
}

// A folder of the user's must stay where it is.
TEST_F(FusionNodeTest, AFolderInPlaceOfTheStateIsRefusedAndLeftAlone) {
  const FusionConfig config = ConfigWithState();
  std::filesystem::create_directories(config.state_file);
  for (const bool fresh : {false, true}) {
    TestBus bus;
    const Result<std::unique_ptr<Node>> node = MakeFusionNode(bus, config, fresh);
    ASSERT_FALSE(node.ok());
    EXPECT_NE(node.error().message.find(config.state_file.string() + " is a folder"),
              std::string::npos)
        << node.error().message;
    EXPECT_TRUE(std::filesystem::is_directory(config.state_file));
    EXPECT_FALSE(std::filesystem::exists(config.state_file.string() + ".bad"));
  }
}

TEST_F(FusionNodeTest, AStateBelowWhatIsNoFolderIsRefused) {
  FusionConfig config = ConfigWithState();
  std::filesystem::create_directories(config.state_file.parent_path());
  std::ofstream(config.state_file) << "a file";
  config.state_file /= "fusion.state";
  TestBus bus;
  const Result<std::unique_ptr<Node>> node = MakeFusionNode(bus, config, false);
  ASSERT_FALSE(node.ok());
  EXPECT_NE(node.error().message.find("can't be made"), std::string::npos) << node.error().message;
}

// Damaged and foreign files: the run starts anew, and the file is kept aside.
TEST_F(FusionNodeTest, AStateThatIsNoneIsMovedAside) {
  const FusionConfig config = ConfigWithState();
  {
    TestBus bus;
    const std::unique_ptr<Node> node = MustMake(bus, config);
    World world(bus);
    for (int i = 0; i < 4; ++i) world.Frame();
  }
  std::ostringstream content;
  content << std::ifstream(config.state_file).rdbuf();
  const std::string good = content.str();
  ASSERT_GT(good.size(), 500U);
  std::string flipped = good;
  flipped[good.size() / 2] = static_cast<char>(flipped[good.size() / 2] ^ 1);
  for (const std::string& bad : {std::string(),
                                 std::string("not a state\n"),
                                 good.substr(0, good.size() - 3),
                                 good.substr(0, 30),
                                 flipped,
                                 good + "x"}) {
    std::ofstream(config.state_file) << bad;
    testing::internal::CaptureStderr();
    TestBus bus;
    const std::unique_ptr<Node> node = MustMake(bus, config);
    EXPECT_NE(testing::internal::GetCapturedStderr().find(".bad"), std::string::npos);
    EXPECT_FALSE(std::filesystem::exists(config.state_file));
    std::ostringstream kept;
    kept << std::ifstream(config.state_file.string() + ".bad").rdbuf();
    EXPECT_EQ(kept.str(), bad);
    bus.Send("CAMERA_XTION_TO_WORLD", PoseToMessage(Pose::Identity(), 1));
    EXPECT_TRUE(bus.published().empty());
  }

  std::ofstream(config.state_file) << good;
  FusionConfig other = config;
  other.setup = "bracket";
  testing::internal::CaptureStderr();
  TestBus bus;
  const std::unique_ptr<Node> node = MustMake(bus, other);
  EXPECT_NE(testing::internal::GetCapturedStderr().find("another set-up"), std::string::npos);
}

TEST_F(FusionNodeTest, TwoRunsPublishTheSameBytes) {
  TestBus a;
  TestBus b;
  const std::unique_ptr<Node> node_a = MustMake(a, MakeConfig());
  const std::unique_ptr<Node> node_b = MustMake(b, MakeConfig());
  World(a).RunToTheEnd();
  World(b).RunToTheEnd();
  EXPECT_EQ(a.published(), b.published());
}

// Of detections that scatter about one axis of the world, the one that they are told of.
TEST_F(FusionNodeTest, TellsHowDetectionsScatter) {
  ObjectEstimate object;
  object.peaks.resize(2);
  object.peaks[1].covariance << 0, 1, 2, 3, 4, 5, 6, 7, 8;
  const object_estimates_v3_t message = ObjectsToMessage({{object}});
  const object_estimate_v3_t& told = message.objects.at(0);
  ASSERT_EQ(told.num_peaks, 2);
  for (int i = 0; i < 9; ++i) EXPECT_EQ(told.peaks[1].covariance[i], i);

  TestBus bus;
  const std::unique_ptr<Node> node = MustMake(bus, MakeConfig());
  World world(bus);
  world.error_axis_ = Eigen::Vector3d(0.6, 0.0, 0.8);
  world.RunToTheEnd();
  for (const object_estimate_v3_t& each : bus.Last<object_estimates_v3_t>("OBJECTS").objects) {
    const Eigen::Map<const Eigen::Matrix3d> covariance(each.peaks.front().covariance);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
    const double sigma_deg = std::sqrt(solver.eigenvalues()[2]) / kDegree;
    EXPECT_GT(sigma_deg, 0.2);
    EXPECT_LT(sigma_deg, 3.0);
    EXPECT_LT(solver.eigenvalues()[1], 1e-3 * solver.eigenvalues()[2]);
    EXPECT_GT(std::abs(solver.eigenvectors().col(2).dot(world.error_axis_)), 0.999);
    const double spread = each.peaks.front().spread;
    EXPECT_NEAR(covariance.trace(), spread * spread, 1e-12);
  }
}

}  // namespace
}  // namespace vantage
