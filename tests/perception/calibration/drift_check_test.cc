#include "perception/calibration/drift_check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "common/rng.h"
#include "perception/calibration/closed_form.h"

namespace vantage {
namespace {

using State = DriftReport::State;

Eigen::Vector3d Normal(double sigma, Rng* rng) {
  return sigma * Eigen::Vector3d(rng->Normal(), rng->Normal(), rng->Normal());
}

Pose Shaken(const Pose& pose, double rotation, double translation, Rng* rng) {
  Pose shaken = pose;
  shaken.linear() = ExpSo3(Normal(rotation, rng)) * pose.linear();
  shaken.translation() += Normal(translation, rng);
  return shaken;
}

/// A calibrated cell in which something may move.
class World {
 public:
  World(HandEyeSetup setup, uint64_t seed) : setup_(setup), rng_(seed) {
    T_x_ = Eigen::Translation3d(0.03, -0.06, 0.05) *
           Eigen::AngleAxisd(0.4, Eigen::Vector3d(0.2, 0.1, 1.0).normalized());
    T_y_ = Eigen::Translation3d(0.5, 0.1, 0.0) *
           Eigen::AngleAxisd(180.0 * kDegree, Eigen::Vector3d::UnitX());
    // The calibration knows both with errors of its own.
    calibration.setup = setup;
    constexpr double kRotation = 0.01 * kDegree;
    constexpr double kTranslation = 5e-5;
    calibration.T_x = Shaken(T_x_, kRotation, kTranslation, &rng_);
    calibration.T_y = Shaken(T_y_, kRotation, kTranslation, &rng_);
    Eigen::Matrix<double, 6, 1> sigmas;
    sigmas << Eigen::Vector3d::Constant(kRotation), Eigen::Vector3d::Constant(kTranslation);
    calibration.covariance = sigmas.cwiseAbs2().asDiagonal();
    calibration.target_covariance = calibration.covariance;
  }

  DriftView View(int reference = 0, const Pose& T_y_reference_offset = Pose::Identity()) {
    const HandEyeNoise noise;
    const Pose B = Eigen::Translation3d(Normal(0.05, &rng_) + Eigen::Vector3d(0.0, 0.0, 0.5)) *
                   ExpSo3(Normal(0.4, &rng_));
    const Pose T_y = T_y_ * T_y_reference_offset;
    const Pose T_base_hand = EquationOfHand(setup_, T_y * (T_x_ * B).inverse(Eigen::Isometry));
    DriftView view;
    view.T_base_hand = T_base_hand;
    view.T_base_hand.linear() = T_base_hand.linear() * ExpSo3(Normal(noise.robot_rotation, &rng_));
    view.T_base_hand.translation() += Normal(noise.robot_translation, &rng_);
    view.T_camera_target = Shaken(B, noise.camera_rotation, noise.camera_translation, &rng_);
    Eigen::Matrix<double, 6, 1> sigmas;
    sigmas << Eigen::Vector3d::Constant(noise.camera_rotation),
        Eigen::Vector3d::Constant(noise.camera_translation);
    view.camera_covariance = sigmas.cwiseAbs2().asDiagonal();
    view.reference = reference;
    view.pixel_rms = 0.2;
    return view;
  }
  void MoveCamera(const Pose& by) { T_x_ = T_x_ * by; }
  void MoveTarget(const Pose& by) { T_y_ = T_y_ * by; }

  HandEyeResult calibration;

 private:
  HandEyeSetup setup_;
  Rng rng_;
  Pose T_x_, T_y_;
};

Pose Knock(double millimetres, double degrees) {
  return Eigen::Translation3d(1e-3 * millimetres, 0.0, 0.0) *
         Eigen::AngleAxisd(degrees * kDegree, Eigen::Vector3d::UnitY());
}

TEST(DriftCheck, HoldsWhileNothingMovesAsOftenAsItClaims) {
  DriftCheckParameters parameters;
  parameters.false_alarms = 0.5;  // In 1,000 views; so that there is something to count.
  int alarms = 0;
  constexpr int kRuns = 20;
  constexpr int kViews = 100;
  for (int run = 0; run < kRuns; ++run) {
    World world(run % 2 == 0 ? HandEyeSetup::kEyeInHand : HandEyeSetup::kEyeToHand,
                100 + static_cast<uint64_t>(run));
    DriftCheck check(parameters, world.calibration, 0.2);
    for (int i = 0; i < kViews; ++i) {
      check.Add(world.View());
      const DriftReport report = check.Report();
      if (report.state == State::kDrifted) {
        ++alarms;
        break;
      }
      EXPECT_EQ(report.state, i + 1 < parameters.least_views ? State::kUnknown : State::kHolds);
    }
  }
  // 2,000 views: at most one alarm is expected, more than 4 of a Poisson of 1 are one in 270.
  EXPECT_LE(alarms, 4);
}

TEST(DriftCheck, AKnockOfTheCameraIsSeenInAFewViewsAndNamed) {
  for (const HandEyeSetup setup : {HandEyeSetup::kEyeInHand, HandEyeSetup::kEyeToHand}) {
    World world(setup, 7);
    DriftCheck check({}, world.calibration, 0.2);
    for (int i = 0; i < 20; ++i) check.Add(world.View());
    ASSERT_EQ(check.Report().state, State::kHolds) << check.Report().reason;
    world.MoveCamera(Knock(2.0, 0.5));
    int views = 0;
    while (check.Report().state != State::kDrifted && views < 20) {
      check.Add(world.View());
      ++views;
    }
    EXPECT_LE(views, 3);
    for (int i = 0; i < 20; ++i) check.Add(world.View());
    const DriftReport report = check.Report();
    EXPECT_NE(report.reason.find("the camera has moved"), std::string::npos) << report.reason;
    EXPECT_NEAR(report.rotation, 0.5 * kDegree, 0.1 * kDegree);
    EXPECT_NEAR(report.translation, 0.002, 0.0005);
    EXPECT_LT(report.rotation_sigma, 0.1 * kDegree);
  }
}

TEST(DriftCheck, AMovedTargetIsToldFromAMovedCamera) {
  World world(HandEyeSetup::kEyeInHand, 8);
  DriftCheck check({}, world.calibration, 0.2);
  world.MoveTarget(Knock(5.0, 1.0));
  for (int i = 0; i < 20; ++i) check.Add(world.View());
  const DriftReport report = check.Report();
  EXPECT_EQ(report.state, State::kDrifted);
  EXPECT_NE(report.reason.find("the target has moved"), std::string::npos) << report.reason;
  EXPECT_NEAR(report.rotation, 1.0 * kDegree, 0.1 * kDegree);
}

TEST(DriftCheck, ObjectsThatLieStillTellToo) {
  const Pose aside = Eigen::Translation3d(0.05, 0.02, 0.0) * Pose::Identity();
  for (const bool knocked : {false, true}) {
    World world(HandEyeSetup::kEyeInHand, 9);
    if (knocked) world.MoveCamera(Knock(5.0, 2.0));
    DriftCheck check({}, world.calibration, 0.0);
    for (int i = 0; i < 24; ++i) {
      DriftView view = i % 2 == 0 ? world.View(1) : world.View(2, aside);
      // Positions alone.
      view.camera_covariance.topLeftCorner<3, 3>().setIdentity();
      view.pixel_rms = 0.0;
      check.Add(view);
    }
    EXPECT_EQ(check.Report().state, knocked ? State::kDrifted : State::kHolds)
        << check.Report().reason;
  }
}

TEST(DriftCheck, ImagesFromOnePlaceCountOnce) {
  World world(HandEyeSetup::kEyeInHand, 10);
  DriftCheck check({}, world.calibration, 0.2);
  const DriftView view = world.View();
  for (int i = 0; i < 50; ++i) check.Add(view);
  EXPECT_EQ(check.Report().num_views, 1);
  EXPECT_EQ(check.Report().state, State::kUnknown);
}

TEST(DriftCheck, PixelsThatFitNoLongerAreTheLens) {
  World world(HandEyeSetup::kEyeInHand, 11);
  DriftCheck check({}, world.calibration, 0.2);
  for (int i = 0; i < 5; ++i) {
    DriftView view = world.View();
    view.pixel_rms = 0.5;
    check.Add(view);
  }
  EXPECT_EQ(check.Report().state, State::kDistorted);
  EXPECT_NE(check.Report().reason.find("0.50 px"), std::string::npos) << check.Report().reason;
}

TEST(DriftCheck, NothingSeenIsNothingKnown) {
  const World world(HandEyeSetup::kEyeInHand, 12);
  EXPECT_EQ(DriftCheck({}, world.calibration, 0.2).Report().state, State::kUnknown);
}

TEST(DriftCheckParameters, ValidateNamesTheBound) {
  DriftCheckParameters parameters;
  EXPECT_TRUE(parameters.Validate().ok());
  parameters.window = 2;
  EXPECT_FALSE(parameters.Validate().ok());
  parameters = {};
  parameters.false_alarms = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(parameters.Validate().ok());
  parameters = {};
  parameters.least_views = 25;
  ASSERT_FALSE(parameters.Validate().ok());
  EXPECT_NE(parameters.Validate().error().message.find("least_views is 25"), std::string::npos);
}

}  // namespace
}  // namespace vantage
