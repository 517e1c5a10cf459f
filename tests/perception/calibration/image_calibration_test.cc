#include "perception/calibration/image_calibration.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

#include "perception/calibration/target_pose.h"
#include "simulated_image_views.h"

namespace vantage {
namespace {

constexpr HandEyeSetup kSetups[] = {HandEyeSetup::kEyeInHand, HandEyeSetup::kEyeToHand};

const CalibrationTarget kSmallGrid{.columns = 2, .rows = 2, .size = 0.06, .gap = 0.02};

HandEyeNoise NoNoise() { return {.robot_rotation = 0.0, .robot_translation = 0.0, .pixel = 0.0}; }

Result<HandEyeResult> Calibrate(const SimulatedImageRequest& request,
                                const SimulatedImageViews& made,
                                ImageCalibrationOptions options = {}) {
  return CalibrateFromImages(
      request.setup, made.views, request.camera, request.distortion, options);
}

double SquaredRadius(const HandEyeResult& result, const Pose& truth) {
  const auto error = PoseError(result.T_x, truth);
  return error.dot(result.covariance.ldlt().solve(error));
}

TEST(CalibrateFromImages, ExactWithoutNoise) {
  Rng rng(1);
  for (const HandEyeSetup setup : kSetups) {
    const SimulatedImageRequest request{
        .setup = setup,
        .views = 8,
        .noise = NoNoise(),
        .distortion = {.k1 = -0.1, .k2 = 0.05, .p1 = 0.001, .p2 = -0.002, .k3 = 0.01}};
    const SimulatedImageViews made = SimulateImageViews(request, rng);
    const auto result = Calibrate(request, made);
    ASSERT_TRUE(result.ok()) << result.error().message;
    EXPECT_LT(PoseError(result->T_x, made.T_x).norm(), 1e-6);
    EXPECT_LT(PoseError(result->T_y, made.T_y).norm(), 1e-6);
    EXPECT_TRUE(result->observability.is_sufficient) << result->observability.reason;
    ASSERT_EQ(result->views.size(), 8U);
    for (const ViewResidual& view : result->views) {
      EXPECT_FALSE(view.is_outlier);
      EXPECT_LT(view.pixels, 1e-3);
    }
  }
}

/// Share of trials whose 95 % ellipsoid holds the truth. Of 100 trials it has a standard deviation
/// of 2 %.
double Coverage(const SimulatedImageRequest& request, int trials, uint64_t seed) {
  Rng rng(seed);
  int held = 0;
  for (int trial = 0; trial < trials; ++trial) {
    const SimulatedImageViews made = SimulateImageViews(request, rng);
    const auto result = Calibrate(request, made);
    EXPECT_TRUE(result.ok());
    if (result.ok() && SquaredRadius(*result, made.T_x) <= result->squared_radius_95) ++held;
  }
  return static_cast<double>(held) / trials;
}

TEST(CalibrateFromImages, EllipsoidsHoldTheTruth) {
  for (const HandEyeSetup setup : kSetups) {
    const double coverage = Coverage({.setup = setup, .target = kSmallGrid, .views = 15}, 100, 2);
    EXPECT_GE(coverage, 0.89);
    EXPECT_LE(coverage, 0.995);
  }
}

TEST(CalibrateFromImages, EllipsoidsHoldTheTruthWhereTheRobotIsMuchWorseThanTold) {
  const SimulatedImageRequest request{
      .target = kSmallGrid,
      .views = 15,
      .noise = {.robot_rotation = 0.3 * kDegree, .robot_translation = 0.003, .pixel = 0.4}};
  const double coverage = Coverage(request, 100, 3);
  EXPECT_GE(coverage, 0.89);
  EXPECT_LE(coverage, 0.995);
}

TEST(CalibrateFromImages, ErrorIsCloseToTheLeastPossible) {
  // The covariance at the true noise is the Cramer-Rao bound.
  Rng rng(4);
  const SimulatedImageRequest request{.target = kSmallGrid, .views = 15};
  double squares = 0.0;
  constexpr int kTrials = 100;
  for (int trial = 0; trial < kTrials; ++trial) {
    const SimulatedImageViews made = SimulateImageViews(request, rng);
    const auto result = Calibrate(request, made);
    ASSERT_TRUE(result.ok());
    squares += SquaredRadius(*result, made.T_x) * result->noise_scale * result->noise_scale;
  }
  // 1.05 times the bound in each of 6 directions, and three standard deviations of this sum.
  EXPECT_LT(squares / kTrials, 6.0 * 1.05 * 1.05 + 3.0 * std::sqrt(12.0 / kTrials));
}

TEST(CalibrateFromImages, OutliersAreListedAndLeftOut) {
  Rng rng(5);
  for (const HandEyeSetup setup : kSetups) {
    const SimulatedImageRequest request{
        .setup = setup, .target = kSmallGrid, .views = 20, .outliers = 6};
    for (int trial = 0; trial < 10; ++trial) {
      const SimulatedImageViews made = SimulateImageViews(request, rng);
      const auto result = Calibrate(request, made);
      ASSERT_TRUE(result.ok());
      for (size_t i = 0; i < 6; ++i) EXPECT_TRUE(result->views[i].is_outlier);
      EXPECT_LE(std::count_if(result->views.begin() + 6,
                              result->views.end(),
                              [](const ViewResidual& view) { return view.is_outlier; }),
                1);
      EXPECT_LT(PoseError(result->T_x, made.T_x).tail<3>().norm(), 0.001);
    }
  }
}

TEST(CalibrateFromImages, AWrongPointHardlyCounts) {
  Rng rng(6);
  const SimulatedImageRequest request{.views = 12};
  SimulatedImageViews made = SimulateImageViews(request, rng);
  const auto clean = Calibrate(request, made);
  made.views[3].points[17].pixel += Eigen::Vector2d(6.0, -4.0);
  const auto spoilt = Calibrate(request, made);
  ASSERT_TRUE(clean.ok() && spoilt.ok());
  EXPECT_FALSE(spoilt->views[3].is_outlier);
  const auto moved = PoseError(spoilt->T_x, clean->T_x);
  EXPECT_LT(moved.dot(clean->covariance.ldlt().solve(moved)), 0.1);
}

TEST(CalibrateFromImages, CameraAndLensAreRecovered) {
  Rng rng(7);
  for (const HandEyeSetup setup : kSetups) {
    SimulatedImageRequest request{
        .setup = setup, .views = 20, .distortion = {.k1 = -0.08, .k2 = 0.1}};
    const SimulatedImageViews made = SimulateImageViews(request, rng);
    const CameraModel truth = request.camera;
    const LensDistortion lens = request.distortion;
    request.camera.fx *= 1.01;
    request.camera.fy *= 1.01;
    request.camera.cx += 3.0;
    request.distortion = {};
    const auto result =
        Calibrate(request, made, {.estimate_focal_lengths = true, .estimate_distortion = true});
    ASSERT_TRUE(result.ok()) << result.error().message;
    ASSERT_TRUE(result->camera && result->distortion);
    EXPECT_NEAR(result->camera->fx, truth.fx, 0.5);
    EXPECT_NEAR(result->camera->fy, truth.fy, 0.5);
    EXPECT_NEAR(result->camera->cx, truth.cx, 1.0);
    EXPECT_NEAR(result->camera->cy, truth.cy, 1.0);
    EXPECT_NEAR(result->distortion->k1, lens.k1, 0.01);
    EXPECT_LT(SquaredRadius(*result, made.T_x), 2.0 * result->squared_radius_95);
    // With the wrong camera the result is worse.
    const auto wrong = Calibrate(request, made);
    ASSERT_TRUE(wrong.ok());
    EXPECT_GT(PoseError(wrong->T_x, made.T_x).tail<3>().norm(),
              3.0 * PoseError(result->T_x, made.T_x).tail<3>().norm());
  }
}

TEST(CalibrateFromImages, RobotScaleIsRecovered) {
  Rng rng(8);
  for (const HandEyeSetup setup : kSetups) {
    const SimulatedImageRequest request{.setup = setup, .views = 20, .robot_scale = 1.01};
    const SimulatedImageViews made = SimulateImageViews(request, rng);
    const auto result = Calibrate(request, made, {.estimate_robot_scale = true});
    ASSERT_TRUE(result.ok()) << result.error().message;
    ASSERT_TRUE(result->robot_scale.has_value());
    EXPECT_NEAR(*result->robot_scale, 1.01, 4.0 * result->robot_scale_sigma);
    EXPECT_LT(result->robot_scale_sigma, 0.001);
  }
}

TEST(CalibrateFromImages, TimeOffsetIsRecovered) {
  constexpr double kOffset = 0.045;  // s
  Rng rng(9);
  for (const HandEyeSetup setup : kSetups) {
    const SimulatedImageRequest request{.setup = setup, .views = 20};
    SimulatedImageViews made = SimulateImageViews(request, rng);
    // Each view is taken in the middle of a motion of its own; its time stamp is early.
    std::vector<HandTrajectory::Sample> samples;
    for (size_t i = 0; i < made.views.size(); ++i) {
      ImageView& view = made.views[i];
      const int64_t utime = 10'000'000 * static_cast<int64_t>(i + 1);
      view.utime = utime - static_cast<int64_t>(1e6 * kOffset);
      const Eigen::Vector3d turn = 0.3 * rng.UnitVector();
      const Eigen::Vector3d velocity = 0.2 * rng.UnitVector();
      for (int step = -150; step <= 150; ++step) {
        const double t = 0.01 * step;
        Pose pose = view.T_base_hand;
        pose.linear() = pose.linear() * ExpSo3(t * turn).toRotationMatrix();
        pose.translation() += t * velocity;
        samples.push_back({utime + 10'000 * step, pose});
      }
    }
    const HandTrajectory trajectory(samples);
    const auto result = Calibrate(request, made, {.trajectory = &trajectory});
    ASSERT_TRUE(result.ok()) << result.error().message;
    ASSERT_TRUE(result->time_offset.has_value());
    EXPECT_NEAR(*result->time_offset, kOffset, 4.0 * result->time_offset_sigma);
    EXPECT_LT(result->time_offset_sigma, 0.001);
    EXPECT_LT(SquaredRadius(*result, made.T_x), 2.0 * result->squared_radius_95);
  }
}

TEST(CalibrateFromImages, PosesOfAFlatTagAreChosenTogether) {
  Rng rng(10);
  const SimulatedImageRequest request{.setup = HandEyeSetup::kEyeToHand,
                                      .target = {.columns = 1, .rows = 1, .size = 0.05},
                                      .views = 20,
                                      .distance = 0.7,
                                      .tilt = 0.35,
                                      .noise = {.pixel = 0.3}};
  int wrong = 0;
  for (int trial = 0; trial < 10; ++trial) {
    const SimulatedImageViews made = SimulateImageViews(request, rng);
    for (size_t i = 0; i < made.views.size(); ++i) {
      const auto poses = FindTargetPoses(made.views[i].points, request.camera, {}, 0.3);
      ASSERT_TRUE(poses.ok());
      const auto error = PoseError((*poses)[0].T_camera_target, made.T_camera_target[i]);
      if (error.dot((*poses)[0].covariance.ldlt().solve(error)) > 50.0) ++wrong;
    }
    const auto result = Calibrate(request, made);
    ASSERT_TRUE(result.ok());
    EXPECT_LE(std::count_if(result->views.begin(),
                            result->views.end(),
                            [](const ViewResidual& view) { return view.is_outlier; }),
              1);
    EXPECT_LT(SquaredRadius(*result, made.T_x), 2.0 * result->squared_radius_95);
  }
  EXPECT_GT(wrong, 5);
}

TEST(CalibrateFromImages, LeavingAViewOutIsCalibratingWithoutIt) {
  Rng rng(11);
  const SimulatedImageRequest request{.target = kSmallGrid, .views = 10};
  const SimulatedImageViews made = SimulateImageViews(request, rng);
  const auto all = Calibrate(request, made);
  ASSERT_TRUE(all.ok());
  for (const size_t left_out : {size_t{0}, size_t{5}}) {
    SimulatedImageViews fewer = made;
    fewer.views.erase(fewer.views.begin() + static_cast<std::ptrdiff_t>(left_out));
    const auto without = Calibrate(request, fewer);
    ASSERT_TRUE(without.ok());
    const auto poses = FindTargetPoses(made.views[left_out].points, request.camera, {}, 0.2);
    const Pose through =
        made.views[left_out].T_base_hand * without->T_x * (*poses)[0].T_camera_target;
    const auto error = PoseError(through, without->T_y);
    EXPECT_NEAR(all->views[left_out].left_out_translation, error.tail<3>().norm(), 5e-5);
    EXPECT_NEAR(all->views[left_out].left_out_rotation, error.head<3>().norm(), 1e-4);
    EXPECT_GT(all->views[left_out].left_out_translation, all->views[left_out].translation);
  }
}

TEST(CalibrateFromImages, SaysWhereMotionsDontFixX) {
  Rng rng(12);
  SimulatedImageRequest request{.views = 12};
  SimulatedImageViews made = SimulateImageViews(request, rng);
  // The same pose of the hand, turned about the camera's axis only.
  for (size_t i = 0; i < made.views.size(); ++i) {
    const Pose B = MakePose(ExpSo3({0.0, 0.0, 0.2 * static_cast<double>(i)}), {0.0, 0.0, 0.5});
    const Pose hand = made.T_y * B.inverse() * made.T_x.inverse();
    made.views[i].T_base_hand = Disturbed(hand, 3e-4, 1e-4, rng);
    for (TargetPoint& point : made.views[i].points) {
      const Eigen::Vector2d noise(0.2 * rng.Normal(), 0.0);
      point.pixel = request.camera.Project(B * point.p_target) + noise;
    }
  }
  const auto result = Calibrate(request, made);
  ASSERT_TRUE(result.ok()) << result.error().message;
  EXPECT_FALSE(result->observability.is_sufficient);
  EXPECT_NE(result->observability.reason.find("add views"), std::string::npos);
}

TEST(CalibrateFromImages, TheSameTwice) {
  Rng rng(13);
  const SimulatedImageRequest request{.views = 8};
  const SimulatedImageViews made = SimulateImageViews(request, rng);
  const auto a = Calibrate(request, made);
  const auto b = Calibrate(request, made);
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_EQ(a->T_x.matrix(), b->T_x.matrix());
  EXPECT_EQ(a->covariance, b->covariance);
}

TEST(CalibrateFromImages, ViewsWithoutTheTargetAreListed) {
  Rng rng(14);
  const SimulatedImageRequest request{.views = 9};
  SimulatedImageViews made = SimulateImageViews(request, rng);
  made.views[4].points.clear();
  made.views[6].points.resize(3);
  const auto result = Calibrate(request, made);
  ASSERT_TRUE(result.ok());
  ASSERT_EQ(result->views.size(), 9U);
  for (size_t i = 0; i < 9; ++i) EXPECT_EQ(result->views[i].is_outlier, i == 4 || i == 6);
}

TEST(CalibrateFromImages, NamesWhatIsWrong) {
  Rng rng(15);
  const SimulatedImageRequest request{.views = 6};
  const SimulatedImageViews good = SimulateImageViews(request, rng);
  const auto error = [&](const SimulatedImageViews& made, ImageCalibrationOptions options = {}) {
    const auto result = Calibrate(request, made, options);
    return result.ok() ? std::string() : result.error().message;
  };
  EXPECT_EQ(error(good), "");
  SimulatedImageViews made = good;
  made.views.resize(2);
  EXPECT_NE(error(made).find("2 of 2 views"), std::string::npos);
  EXPECT_NE(error({}).find("0 of 0 views"), std::string::npos);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double bad : {nan, std::numeric_limits<double>::infinity()}) {
    made = good;
    made.views[1].T_base_hand.translation().x() = bad;
    EXPECT_NE(error(made).find("view 1: the hand is at"), std::string::npos) << error(made);
    made = good;
    made.views[1].T_base_hand.linear()(0, 0) = bad;
    EXPECT_NE(error(made).find("view 1"), std::string::npos);
    made = good;
    made.views[1].points[2].pixel.y() = bad;
    EXPECT_NE(error(made).find("view 1: point"), std::string::npos);
    ImageCalibrationOptions options;
    options.noise.pixel = bad;
    EXPECT_NE(error(good, options).find("noise"), std::string::npos);
  }
  made = good;
  made.views[1].T_base_hand.linear().col(0) *= -1.0;
  EXPECT_NE(error(made), "");
  const HandTrajectory empty;
  EXPECT_NE(error(good, {.trajectory = &empty}).find("time offset"), std::string::npos);
  made = good;
  for (ImageView& view : made.views) view = good.views[0];
  error(made);  // Any answer; no crash.
}

}  // namespace
}  // namespace vantage
