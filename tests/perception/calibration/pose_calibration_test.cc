#include "perception/calibration/pose_calibration.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "perception/calibration/closed_form.h"
#include "tests/perception/calibration/simulated_pose_views.h"

namespace vantage {
namespace {

constexpr HandEyeSetup kSetups[] = {HandEyeSetup::kEyeInHand, HandEyeSetup::kEyeToHand};

/// Sums over simulated trials.
struct Trials {
  double squared_translation = 0.0;
  double squared_rotation = 0.0;
  double bound_translation = 0.0;  ///< traces of the Cramer-Rao bound
  double bound_rotation = 0.0;
  int covered = 0;
  int wrong_views = 0;
};

Trials RunTrials(SimulatedPoseRequest request, int trials) {
  Trials sums;
  for (int trial = 0; trial < trials; ++trial) {
    Rng rng(static_cast<uint64_t>(trial) + 1000);
    SimulatedPoseViews made = SimulatePoseViews(request, rng);
    const Result<HandEyeResult> result = CalibrateFromPoses(made.setup, made.views, {});
    EXPECT_TRUE(result);
    if (!result) continue;
    const Eigen::Matrix<double, 6, 1> error = ErrorOf(result->T_x, made.T_x);
    sums.squared_rotation += error.head<3>().squaredNorm();
    sums.squared_translation += error.tail<3>().squaredNorm();
    const double squared_radius = error.dot(result->covariance.ldlt().solve(error));
    sums.covered += squared_radius <= result->squared_radius_95 ? 1 : 0;
    std::vector<Pose> good;
    for (size_t i = 0; i < made.views.size(); ++i) {
      sums.wrong_views += result->views[i].is_outlier != made.is_outlier[i] ? 1 : 0;
      if (!made.is_outlier[i]) good.push_back(made.T_base_hand[i]);
    }
    made.T_base_hand = good;
    const HandEyeCovariance bound = CramerRaoBound(made, request.noise);
    sums.bound_rotation += bound.topLeftCorner<3, 3>().trace();
    sums.bound_translation += bound.bottomRightCorner<3, 3>().trace();
  }
  return sums;
}

// The bound of 1.05 is checked on more trials by vantage-evaluate --handeye; here chance is some
// 4 % of the ratios and 1.8 % of the coverage.
TEST(PoseCalibration, ReachesTheCramerRaoBoundAndKnowsItsErrors) {
  constexpr int kTrials = 150;
  for (const HandEyeSetup setup : kSetups) {
    for (const double share : {0.0, 0.3}) {
      SimulatedPoseRequest request;
      request.setup = setup;
      request.outlier_share = share;
      const Trials sums = RunTrials(request, kTrials);
      EXPECT_LT(std::sqrt(sums.squared_translation / sums.bound_translation), 1.1);
      EXPECT_LT(std::sqrt(sums.squared_rotation / sums.bound_rotation), 1.1);
      EXPECT_GT(std::sqrt(sums.squared_translation / sums.bound_translation), 0.9);
      EXPECT_NEAR(static_cast<double>(sums.covered) / kTrials, 0.95, 0.05);
      EXPECT_LE(sums.wrong_views, 20);  // Of 4,500.
    }
  }
}

/// Rotations twice, translations eight times as noisy as claimed.
TEST(PoseCalibration, KnowsItsErrorsWhenTheNoiseIsNotWhatWasClaimed) {
  SimulatedPoseRequest request;
  request.noise.camera_translation *= 8.0;
  request.noise.robot_translation *= 8.0;
  request.noise.camera_rotation *= 2.0;
  request.noise.robot_rotation *= 2.0;
  const Trials sums = RunTrials(request, 150);
  EXPECT_NEAR(sums.covered / 150.0, 0.95, 0.05);
  EXPECT_LT(std::sqrt(sums.squared_translation / sums.bound_translation), 1.1);
  EXPECT_LE(sums.wrong_views, 20);
}

TEST(PoseCalibration, IsExactWithoutNoise) {
  for (const HandEyeSetup setup : kSetups) {
    Rng rng(4);
    SimulatedPoseRequest request;
    request.setup = setup;
    request.views = 3;
    request.noise = {0.0, 0.0, 0.0, 0.0, 0.0};
    const SimulatedPoseViews made = SimulatePoseViews(request, rng);
    const Result<HandEyeResult> result = CalibrateFromPoses(setup, made.views, {});
    ASSERT_TRUE(result);
    EXPECT_LT(ErrorOf(result->T_x, made.T_x).norm(), 1e-8);
    EXPECT_LT(ErrorOf(result->T_y, made.T_y).norm(), 1e-8);
    EXPECT_TRUE(result->covariance.allFinite());
  }
}

// Another base frame and another hand frame change nothing but the frames.
TEST(PoseCalibration, FollowsTheFrames) {
  Rng rng(8);
  SimulatedPoseRequest request;
  request.outlier_share = 0.2;
  const SimulatedPoseViews made = SimulatePoseViews(request, rng);
  const Pose T_new_base = MakePose(rng.Rotation(), rng.UnitVector());
  std::vector<PoseView> moved = made.views;
  for (PoseView& view : moved) view.T_base_hand = T_new_base * view.T_base_hand;
  const Result<HandEyeResult> first = CalibrateFromPoses(made.setup, made.views, {});
  const Result<HandEyeResult> second = CalibrateFromPoses(made.setup, moved, {});
  ASSERT_TRUE(first && second);
  EXPECT_LT(ErrorOf(second->T_x, first->T_x).norm(), 1e-6);
  EXPECT_LT(ErrorOf(second->T_y, T_new_base * first->T_y).norm(), 1e-6);
  EXPECT_NEAR(first->noise_scale, second->noise_scale, 1e-4);
  for (size_t i = 0; i < moved.size(); ++i) {
    EXPECT_EQ(first->views[i].is_outlier, second->views[i].is_outlier);
  }
}

TEST(PoseCalibration, IsTheSameEveryTime) {
  Rng rng(9);
  SimulatedPoseRequest request;
  request.outlier_share = 0.3;
  const SimulatedPoseViews made = SimulatePoseViews(request, rng);
  const Result<HandEyeResult> first = CalibrateFromPoses(made.setup, made.views, {});
  const Result<HandEyeResult> second = CalibrateFromPoses(made.setup, made.views, {});
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->T_x.matrix(), second->T_x.matrix());
  EXPECT_EQ(first->covariance, second->covariance);
}

// Left-out errors are those of a calibration without the view.
TEST(PoseCalibration, LeftOutErrorsAreThoseOfTheOthers) {
  for (const HandEyeSetup setup : kSetups) {
    Rng rng(10);
    SimulatedPoseRequest request;
    request.setup = setup;
    request.views = 12;
    const SimulatedPoseViews made = SimulatePoseViews(request, rng);
    const Result<HandEyeResult> all = CalibrateFromPoses(setup, made.views, {});
    ASSERT_TRUE(all);
    for (size_t i = 0; i < made.views.size(); ++i) {
      std::vector<PoseView> others = made.views;
      others.erase(others.begin() + static_cast<int64_t>(i));
      const Result<HandEyeResult> without = CalibrateFromPoses(setup, others, {});
      ASSERT_TRUE(without);
      const Pose A = EquationOfHand(setup, made.views[i].T_base_hand);
      const Eigen::Matrix<double, 6, 1> error =
          ErrorOf(A * without->T_x * made.views[i].T_camera_target, without->T_y);
      const ViewResidual& view = all->views[i];
      EXPECT_NEAR(view.left_out_rotation, error.head<3>().norm(), 0.002 * kDegree);
      EXPECT_NEAR(view.left_out_translation, error.tail<3>().norm(), 2e-5);
      EXPECT_GE(view.left_out_translation + 1e-4, view.translation);
    }
  }
}

TEST(PoseCalibration, FindsTheRobotsScale) {
  for (const HandEyeSetup setup : kSetups) {
    Rng rng(12);
    SimulatedPoseRequest request;
    request.setup = setup;
    request.outlier_share = 0.2;
    SimulatedPoseViews made = SimulatePoseViews(request, rng);
    for (PoseView& view : made.views) view.T_base_hand.translation() /= 1.01;
    PoseCalibrationOptions options;
    options.estimate_robot_scale = true;
    const Result<HandEyeResult> result = CalibrateFromPoses(setup, made.views, options);
    ASSERT_TRUE(result);
    ASSERT_TRUE(result->robot_scale);
    EXPECT_NEAR(*result->robot_scale, 1.01, 4.0 * result->robot_scale_sigma);
    EXPECT_LT(result->robot_scale_sigma, 0.002);
    EXPECT_LT(ErrorOf(result->T_x, made.T_x).tail<3>().norm(), 0.003);
  }
}

/// A hand that swings about two axes; images are late.
TEST(PoseCalibration, FindsTheTimeOffset) {
  for (const HandEyeSetup setup : kSetups) {
    for (const double offset : {-0.25, 0.03}) {
      Rng rng(13);
      const auto hand_at = [](double time) {
        return MakePose(ExpSo3({0.5 * std::sin(1.3 * time), 0.4 * std::sin(0.9 * time + 1.0), 0.2}),
                        {0.2 * std::sin(0.7 * time), 0.2 * std::cos(1.1 * time), 0.5});
      };
      std::vector<HandTrajectory::Sample> samples;
      for (int i = 0; i < 4000; ++i) {
        samples.push_back({1'000'000 + 10'000 * i, hand_at(0.01 * i)});
      }
      const HandTrajectory trajectory(samples);
      const Pose T_x = MakePose(rng.Rotation(), 0.1 * rng.UnitVector());
      const Pose T_y = MakePose(rng.Rotation(), 0.7 * rng.UnitVector());
      std::vector<PoseView> views;
      for (int i = 0; i < 40; ++i) {
        PoseView view;
        view.utime = 3'000'000 + 850'123 * i;
        const double time = 1e-6 * static_cast<double>(view.utime) - 1.0 + offset;
        view.T_camera_target = Disturbed(
            (EquationOfHand(setup, hand_at(time)) * T_x).inverse() * T_y, 0.001, 0.0005, rng);
        views.push_back(view);
      }
      PoseCalibrationOptions options;
      options.trajectory = &trajectory;
      const Result<HandEyeResult> result = CalibrateFromPoses(setup, views, options);
      ASSERT_TRUE(result) << result.error().message;
      ASSERT_TRUE(result->time_offset);
      EXPECT_NEAR(*result->time_offset, offset, 4.0 * result->time_offset_sigma);
      EXPECT_LT(result->time_offset_sigma, 0.002);
      EXPECT_LT(ErrorOf(result->T_x, T_x).tail<3>().norm(), 0.003);

      views[3].utime = 0;
      EXPECT_FALSE(CalibrateFromPoses(setup, views, options));
    }
  }
}

TEST(PoseCalibration, RefusesBadInput) {
  Rng rng(14);
  const SimulatedPoseViews made = SimulatePoseViews({}, rng);
  const auto error_of = [&](const std::vector<PoseView>& views,
                            const PoseCalibrationOptions& options = {}) {
    const Result<HandEyeResult> result = CalibrateFromPoses(made.setup, views, options);
    return result ? std::string() : result.error().message;
  };
  EXPECT_NE(error_of({}).find("0 views"), std::string::npos);
  EXPECT_NE(error_of({made.views[0], made.views[1]}).find("2 views"), std::string::npos);
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e200}) {
    std::vector<PoseView> views = made.views;
    views[7].T_base_hand.translation().y() = bad;
    EXPECT_NE(error_of(views).find("view 7, pose of the hand"), std::string::npos);
    views = made.views;
    views[7].T_camera_target.linear()(0, 0) = bad;
    EXPECT_NE(error_of(views).find("view 7, pose of the target"), std::string::npos);
    views = made.views;
    views[7].other_T_camera_target = {made.T_x};
    views[7].other_T_camera_target[0].linear()(1, 0) = bad;
    EXPECT_NE(error_of(views).find("other pose"), std::string::npos);
    views = made.views;
    views[7].covariance = HandEyeCovariance::Identity();
    (*views[7].covariance)(2, 2) = -bad;
    EXPECT_NE(error_of(views).find("covariance"), std::string::npos);
  }
  std::vector<PoseView> mirrored = made.views;
  mirrored[2].T_camera_target.linear().col(0) *= -1.0;
  EXPECT_NE(error_of(mirrored).find("determinant -1"), std::string::npos);
  PoseCalibrationOptions options;
  options.noise.camera_rotation = 0.0;
  EXPECT_NE(error_of(made.views, options).find("camera_rotation"), std::string::npos);
  const std::vector<PoseView> identical(5, made.views[0]);
  const Result<HandEyeResult> result = CalibrateFromPoses(made.setup, identical, {});
  ASSERT_TRUE(result);
  EXPECT_FALSE(result->observability.is_sufficient);
}

/// Poses without any relation are solved without a crash, and are not trusted.
TEST(PoseCalibration, DoesNotTrustNoise) {
  int trusted = 0;
  for (uint64_t seed = 0; seed < 30; ++seed) {
    Rng rng(seed);
    std::vector<PoseView> views(15);
    for (PoseView& view : views) {
      view.T_base_hand = MakePose(rng.Rotation(), rng.UnitVector());
      view.T_camera_target = MakePose(rng.Rotation(), rng.UnitVector());
    }
    const Result<HandEyeResult> result = CalibrateFromPoses(HandEyeSetup::kEyeToHand, views, {});
    if (!result) continue;
    EXPECT_TRUE(result->T_x.matrix().allFinite());
    trusted += result->observability.is_sufficient ? 1 : 0;
  }
  EXPECT_EQ(trusted, 0);
}

// 50 real pairs. The published result has two to three digits; our translation is within its
// rounding, the rotation within that of Euler angles told to 0.01 rad.
TEST(PoseCalibration, AgreesWithMoveItOnRealPairs) {
  const auto file = std::filesystem::path(VANTAGE_SOURCE_DIR) /
                    "../shared/data/handeye/moveit_calibration/pose_samples.json";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not there";
  std::ifstream stream(file);
  std::vector<PoseView> views;
  for (const auto& pair : nlohmann::json::parse(stream)) {
    PoseView view;
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) {
        view.T_base_hand.matrix()(row, column) = pair[0][row][column].get<double>();
        view.T_camera_target.matrix()(row, column) = pair[1][row][column].get<double>();
      }
    }
    views.push_back(view);
  }
  ASSERT_EQ(views.size(), 50U);
  const Result<HandEyeResult> result = CalibrateFromPoses(HandEyeSetup::kEyeToHand, views, {});
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_TRUE(result->observability.is_sufficient);
  const Eigen::Vector3d published(0.659, -0.249, 0.830);
  EXPECT_LT((result->T_x.translation() - published).cwiseAbs().maxCoeff(), 0.0015);
  const Eigen::Quaterniond rotation = Eigen::AngleAxisd(0.23, Eigen::Vector3d::UnitX()) *
                                      Eigen::AngleAxisd(-2.54, Eigen::Vector3d::UnitY()) *
                                      Eigen::AngleAxisd(1.95, Eigen::Vector3d::UnitZ());
  EXPECT_LT(GeodesicAngle(Eigen::Quaterniond(result->T_x.linear()), rotation), 0.5 * kDegree);
  EXPECT_LT(result->translation_rms, 0.005);
  EXPECT_LT(result->rotation_rms, 0.1 * kDegree);
}

}  // namespace
}  // namespace vantage
