#include "drivers/sim/sim_arm.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/rng.h"

namespace vantage {
namespace {

const Eigen::Vector3d kTarget(0.0, 0.0, 0.05);

Pose View(double azimuth_deg, double elevation_deg, double radius = 0.75) {
  return ViewOnSphere(kTarget, azimuth_deg * kDegree, elevation_deg * kDegree, radius);
}

double Distance(const Pose& a, const Pose& b) {
  return (a.translation() - b.translation()).norm() +
         GeodesicAngle(Eigen::Quaterniond(a.linear()), Eigen::Quaterniond(b.linear()));
}

SimArmParameters WithTable() {
  SimArmParameters parameters;
  parameters.table_height = 0.0;
  return parameters;
}

TEST(SimArm, RestsAtItsStart) {
  SimArm arm(WithTable());
  EXPECT_LT(Distance(arm.PoseAt(0.0), View(-90.0, 45.0)), 1e-9);
  EXPECT_LT(Distance(arm.PoseAt(100.0), View(-90.0, 45.0)), 1e-9);
  EXPECT_EQ(arm.Remaining(0.0), 0.0);
}

TEST(SimArm, ArrivesExactly) {
  SimArm arm(WithTable());
  Pose goal = View(30.0, 60.0, 0.6);
  goal.linear() =
      goal.linear() * ExpSo3({0.1, -0.2, 0.7}).toRotationMatrix();  // Rolled, off target.
  ASSERT_TRUE(arm.MoveTo(goal, 5.0).ok());
  const double remaining = arm.Remaining(5.0);
  EXPECT_GT(remaining, 1.0);
  EXPECT_GT(Distance(arm.PoseAt(5.0 + 0.5 * remaining), goal), 0.1);
  EXPECT_LT(Distance(arm.PoseAt(5.0 + remaining + 1e-9), goal), 1e-9);
  EXPECT_EQ(arm.Remaining(5.0 + remaining + 1e-9), 0.0);
}

TEST(SimArm, KeepsItsSpeedLimitsAndOffTheTable) {
  const SimArmParameters parameters = WithTable();
  SimArm arm(parameters);
  Rng rng(3);
  double now = 0.0;
  double fastest = 0.0;
  double fastest_turn = 0.0;
  for (int move = 0; move < 30; ++move) {
    const Pose goal =
        View(rng.Uniform(-180.0, 180.0), rng.Uniform(20.0, 85.0), rng.Uniform(0.4, 1.2));
    if (!arm.CheckReachable(goal).ok()) continue;
    ASSERT_TRUE(arm.MoveTo(goal, now).ok());
    constexpr double kStep = 0.01;
    Pose last = arm.PoseAt(now);
    double last_speed = 0.0;
    while (arm.Remaining(now) > 0.0) {
      now += kStep;
      const Pose pose = arm.PoseAt(now);
      const double speed = (pose.translation() - last.translation()).norm() / kStep;
      fastest = std::max(fastest, speed);
      fastest_turn = std::max(
          fastest_turn,
          GeodesicAngle(Eigen::Quaterniond(last.linear()), Eigen::Quaterniond(pose.linear())) /
              kStep);
      EXPECT_LT(std::abs(speed - last_speed), 0.1);  // Smooth: no jump of the speed.
      EXPECT_GE(pose.translation().z(), 0.1 - 1e-6);
      EXPECT_GE((pose.translation() - kTarget).norm(), 0.4 - 1e-6);
      // On a sphere of views it keeps looking at the target.
      const Eigen::Vector3d to_target = (kTarget - pose.translation()).normalized();
      EXPECT_GT(to_target.dot(pose.linear().col(2)), 0.9999);
      last = pose;
      last_speed = speed;
    }
  }
  EXPECT_LE(fastest, parameters.speed * 1.001);
  EXPECT_LE(fastest_turn, parameters.turn_speed * 1.001);
  EXPECT_GT(std::max(fastest / parameters.speed, fastest_turn / parameters.turn_speed), 0.95);
}

TEST(SimArm, RefusesWithAReason) {
  SimArm arm(WithTable());
  const auto reason = [&arm](const Pose& pose) {
    const Result<void> result = arm.MoveTo(pose, 1.0);
    return result.ok() ? std::string("accepted") : result.error().message;
  };
  EXPECT_EQ(reason(View(0.0, 12.0)), "elevation 12.0 deg is below the lowest 20.0 deg");
  EXPECT_EQ(reason(View(0.0, 88.0)), "elevation 88.0 deg is above the highest 85.0 deg");
  EXPECT_EQ(reason(View(0.0, 45.0, 1.5)), "radius 1.500 m is above the highest 1.200 m");
  EXPECT_EQ(reason(View(0.0, 45.0, 0.2)), "radius 0.200 m is below the lowest 0.400 m");
  Pose nan = View(0.0, 45.0);
  nan.translation().x() = std::nan("");
  EXPECT_EQ(reason(nan), "the pose is not finite");
  EXPECT_EQ(reason(View(0.0, 20.0)), "accepted");
  EXPECT_EQ(arm.destination().translation(), View(0.0, 20.0).translation());

  SimArmParameters high = WithTable();
  high.table_height = 0.1;
  SimArm above(high);
  const Result<void> low = above.CheckReachable(View(0.0, 20.0, 0.41));
  ASSERT_FALSE(low.ok());
  EXPECT_NE(low.error().message.find("clearance of 0.100 m above the table"), std::string::npos);
}

TEST(SimArm, ARefusalLeavesTheMoveAlone) {
  SimArm arm(WithTable());
  ASSERT_TRUE(arm.MoveTo(View(0.0, 45.0), 0.0).ok());
  const double remaining = arm.Remaining(0.5);
  EXPECT_FALSE(arm.MoveTo(View(0.0, 5.0), 0.5).ok());
  EXPECT_EQ(arm.Remaining(0.5), remaining);
  EXPECT_LT(Distance(arm.PoseAt(0.6 + remaining), View(0.0, 45.0)), 1e-9);
}

TEST(SimArm, AViewGivenInMidMoveIsTakenUpOnArrival) {
  SimArm arm(WithTable());
  ASSERT_TRUE(arm.MoveTo(View(0.0, 45.0), 0.0).ok());
  const double first = arm.Remaining(0.0);
  ASSERT_TRUE(arm.MoveTo(View(90.0, 45.0), 0.1).ok());
  ASSERT_TRUE(arm.MoveTo(View(40.0, 60.0), 0.2).ok());  // Replaces the one before.
  const double all = arm.Remaining(0.2) + 0.2;
  EXPECT_GT(all, first + 0.5);
  EXPECT_LT(Distance(arm.PoseAt(first), View(0.0, 45.0)), 1e-6);
  EXPECT_LT(Distance(arm.PoseAt(all + 1e-6), View(40.0, 60.0)), 1e-9);
}

TEST(SimArm, TurnsTheShortWayRound) {
  SimArmParameters parameters = WithTable();
  parameters.start_azimuth = 170.0 * kDegree;
  SimArm arm(parameters);
  ASSERT_TRUE(arm.MoveTo(View(-170.0, 45.0), 0.0).ok());
  EXPECT_LT(arm.Remaining(0.0), 2.0);  // 20 degrees of a circle of 0.53 m: 0.19 m at 0.4 m/s.
}

TEST(SimArmParameters, ValidateNamesWhatIsWrong) {
  EXPECT_TRUE(WithTable().Validate().ok());
  SimArmParameters parameters = WithTable();
  parameters.speed = 0.0;
  EXPECT_NE(parameters.Validate().error().message.find("speed = 0, expected"), std::string::npos);
  parameters = WithTable();
  parameters.start_elevation = 5.0 * kDegree;
  EXPECT_NE(parameters.Validate().error().message.find("start is out of reach: elevation 5.0 deg"),
            std::string::npos);
  parameters = WithTable();
  parameters.start_radius = 0.0;
  EXPECT_FALSE(parameters.Validate().ok());
}

}  // namespace
}  // namespace vantage
