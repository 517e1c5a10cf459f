#include "nodes/sim_arm_node.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "bus/conversions.h"
#include "tests/nodes/clocked_test_bus.h"
#include "vantage/arm_status_t.hpp"
#include "vantage/rigid_transform_t.hpp"

namespace vantage {
namespace {

const Eigen::Vector3d kTarget(0.0, 0.0, 0.05);

Pose View(double azimuth_deg, double elevation_deg) {
  return ViewOnSphere(kTarget, azimuth_deg * kDegree, elevation_deg * kDegree, 0.75);
}

next_view_t NextView(int64_t seq, const Pose& pose) {
  next_view_t view{};
  view.seq = seq;
  view_candidate_t candidate{};
  const rigid_transform_t wire = PoseToMessage(pose, 0);
  std::copy_n(wire.trans, 3, candidate.trans);
  std::copy_n(wire.quat, 4, candidate.quat);
  view.candidates = {candidate};
  view.num_candidates = 1;
  return view;
}

class SimArmNodeTest : public ::testing::Test {
 protected:
  SimArmNodeTest()
      : node_(bus_, SimArmParameters{}, std::nullopt, "XTION", [this] { return steady_us_; }) {
    EXPECT_TRUE(node_.Subscribe().ok());
  }
  void Run(double seconds) {
    for (int64_t us = 0; us < std::llround(1e6 * seconds); us += 5000) {
      node_.Poll();
      bus_.now += 5000;
      steady_us_ += 5000;
    }
  }
  arm_status_t LastStatus() { return bus_.Take<arm_status_t>("ARM_STATUS").back(); }
  Pose LastPose() {
    return *PoseFromMessage(bus_.Take<rigid_transform_t>("CAMERA_XTION_TO_WORLD").back());
  }

  ClockedTestBus bus_;
  int64_t steady_us_ = 77'000'000;
  SimArmNode node_;
};

TEST_F(SimArmNodeTest, PublishesPosesAt100HzAndStatusAt10) {
  Run(2.0);
  const auto poses = bus_.Take<rigid_transform_t>("CAMERA_XTION_TO_WORLD");
  EXPECT_EQ(poses.size(), 200U);
  for (size_t i = 1; i < poses.size(); ++i) EXPECT_EQ(poses[i].utime - poses[i - 1].utime, 10'000);
  EXPECT_LT((PoseFromMessage(poses[0])->translation() - View(-90.0, 45.0).translation()).norm(),
            1e-9);
  const auto statuses = bus_.Take<arm_status_t>("ARM_STATUS");
  EXPECT_NEAR(static_cast<double>(statuses.size()), 20.0, 1.0);
  EXPECT_EQ(statuses.back().state, arm_status_t::RESTING);
  EXPECT_EQ(statuses.back().view_seq, -1);
  EXPECT_EQ(statuses.back().name, "XTION");
  EXPECT_EQ(bus_.state, "ok");
}

TEST_F(SimArmNodeTest, GoesToTheNextViewAndSaysSo) {
  Run(0.2);
  bus_.Send("NEXT_VIEW", NextView(7, View(0.0, 60.0)));
  const arm_status_t moving = LastStatus();
  EXPECT_EQ(moving.state, arm_status_t::MOVING);
  EXPECT_EQ(moving.view_seq, 7);
  EXPECT_GT(moving.remaining, 1.0);
  Run(moving.remaining + 0.2);
  EXPECT_EQ(LastStatus().state, arm_status_t::RESTING);
  EXPECT_LT((LastPose().translation() - View(0.0, 60.0).translation()).norm(), 1e-9);
}

TEST_F(SimArmNodeTest, RefusesOutOfReachWithAReasonUntilTheNextGoodView) {
  bus_.Send("NEXT_VIEW", NextView(1, View(0.0, 10.0)));
  const arm_status_t refused = LastStatus();
  EXPECT_EQ(refused.state, arm_status_t::REFUSED);
  EXPECT_EQ(refused.view_seq, 1);
  EXPECT_EQ(refused.reason, "elevation 10.0 deg is below the lowest 20.0 deg");
  bus_.Send("NEXT_VIEW", NextView(2, View(0.0, 40.0)));
  const arm_status_t accepted = LastStatus();
  EXPECT_EQ(accepted.state, arm_status_t::MOVING);
  EXPECT_EQ(accepted.reason, "");
}

TEST_F(SimArmNodeTest, ARepeatedDecisionIsTakenOnce) {
  const next_view_t view = NextView(3, View(0.0, 60.0));
  bus_.Send("NEXT_VIEW", view);
  const double remaining = LastStatus().remaining;
  Run(1.0);
  bus_.sent.clear();
  bus_.Send("NEXT_VIEW", view);
  EXPECT_TRUE(bus_.sent.empty());
  Run(remaining);
  EXPECT_EQ(LastStatus().state, arm_status_t::RESTING);
}

TEST_F(SimArmNodeTest, ARestartedPlannerMayBeginItsCountAgain) {
  bus_.Send("NEXT_VIEW", NextView(0, View(-60.0, 45.0)));
  Run(5.0);
  bus_.Send("NEXT_VIEW", NextView(0, View(-90.0, 60.0)));
  EXPECT_EQ(LastStatus().state, arm_status_t::MOVING);
  Run(5.0);
  EXPECT_LT((LastPose().translation() - View(-90.0, 60.0).translation()).norm(), 1e-9);
}

TEST_F(SimArmNodeTest, StaysWhenNothingIsSelected) {
  next_view_t view = NextView(4, View(0.0, 60.0));
  view.selected = -1;
  bus_.Send("NEXT_VIEW", view);
  Run(0.5);
  EXPECT_EQ(LastStatus().state, arm_status_t::RESTING);
}

TEST_F(SimArmNodeTest, NonsenseIsRefused) {
  next_view_t view = NextView(5, View(0.0, 60.0));
  view.selected = 1;
  bus_.Send("NEXT_VIEW", view);
  EXPECT_EQ(LastStatus().reason, "candidate 1 is selected of 1");
  view.selected = 0;
  view.candidates[0].quat[0] = 9.0;
  bus_.Send("NEXT_VIEW", view);
  const arm_status_t status = LastStatus();
  EXPECT_EQ(status.state, arm_status_t::REFUSED);
  EXPECT_NE(status.reason.find("norm"), std::string::npos);
}

TEST_F(SimArmNodeTest, AClockThatIsSetBackDoesNotSilenceIt) {
  Run(0.5);
  bus_.now -= 3'600'000'000;
  bus_.sent.clear();
  Run(0.5);
  EXPECT_GE(bus_.Take<rigid_transform_t>("CAMERA_XTION_TO_WORLD").size(), 49U);
  EXPECT_GE(bus_.Take<arm_status_t>("ARM_STATUS").size(), 4U);
}

TEST_F(SimArmNodeTest, AClockThatIsSetDoesNotMoveTheArm) {
  bus_.Send("NEXT_VIEW", NextView(1, View(90.0, 60.0)));
  Run(1.0);
  for (const int64_t step : {-2'000'000LL, 2'000'000LL, -3'600'000'000LL}) {
    const rigid_transform_t before = bus_.Take<rigid_transform_t>("CAMERA_XTION_TO_WORLD").back();
    const Eigen::Vector3d p_before = PoseFromMessage(before)->translation();
    bus_.now += step;
    Run(0.1);
    const auto poses = bus_.Take<rigid_transform_t>("CAMERA_XTION_TO_WORLD");
    EXPECT_GE(poses.size(), 9U);
    // Stamped with the clock as it is now, and where it was with no step.
    EXPECT_NEAR(1e-6 * static_cast<double>(poses.front().utime - before.utime - step), 0.01, 0.011);
    const double moved = (PoseFromMessage(poses.front())->translation() - p_before).norm();
    EXPECT_LT(moved, 1.1 * 0.02 * SimArmParameters().speed);
    EXPECT_GT((PoseFromMessage(poses.back())->translation() - p_before).norm(), 0.01);
    bus_.Send("NEXT_VIEW", NextView(1, View(90.0, 60.0)));  // Said again: nothing new.
    bus_.sent["CAMERA_XTION_TO_WORLD"].push_back(Encode(poses.back()));
  }
  Run(20.0);
  EXPECT_EQ(LastStatus().state, arm_status_t::RESTING);
  EXPECT_LT((LastPose().translation() - View(90.0, 60.0).translation()).norm(), 1e-9);
}

TEST(SimArmNodeWithAHand, GoesWhereItsHandIsAskedToAndHidesTheCamera) {
  ClockedTestBus bus;
  int64_t steady_us = 0;
  SimHandParameters hand;
  hand.T_hand_camera =
      Eigen::Translation3d(0.02, -0.05, 0.04) * Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitX());
  SimArmNode node(bus, SimArmParameters{}, hand, "XTION", [&steady_us] { return steady_us; });
  ASSERT_TRUE(node.Subscribe().ok());
  EXPECT_FALSE(bus.handlers.contains("NEXT_VIEW"));
  const Pose camera = View(-60.0, 50.0);
  const Pose T_base_hand = camera * hand.T_hand_camera.inverse(Eigen::Isometry);
  bus.Send("NEXT_HAND_POSE", NextView(1, T_base_hand));
  for (; steady_us < 5'000'000; steady_us += 5000, bus.now += 5000) node.Poll();
  EXPECT_FALSE(bus.sent.contains("CAMERA_XTION_TO_WORLD"));
  const auto hands = bus.Take<rigid_transform_t>("HAND_TO_BASE");
  const auto cameras = bus.Take<rigid_transform_t>("SIM_CAMERA_XTION_TO_WORLD");
  EXPECT_EQ(hands.size(), cameras.size());
  EXPECT_NEAR(static_cast<double>(hands.size()), 500.0, 2.0);
  EXPECT_TRUE(PoseFromMessage(hands.back())->isApprox(T_base_hand, 1e-9));
  EXPECT_TRUE(PoseFromMessage(cameras.back())->isApprox(camera, 1e-9));
  EXPECT_EQ(hands.back().utime, cameras.back().utime);
  bus.Send("NEXT_HAND_POSE", NextView(2, Pose::Identity()));
  EXPECT_EQ(bus.Take<arm_status_t>("ARM_STATUS").back().state, arm_status_t::REFUSED);
}

TEST(MakeSimArmNode, NamesAWrongKey) {
  ClockedTestBus bus;
  Result<ConfigReader> config = ConfigReader::Parse("[sim.arm]\nspeed = 1.0\n", "test.toml");
  ASSERT_TRUE(config.ok());
  const auto node = MakeSimArmNode(bus, *config, {});
  ASSERT_FALSE(node.ok());
  EXPECT_NE(node.error().message.find("sim.arm.speed"), std::string::npos);
}

}  // namespace
}  // namespace vantage
