#include "perception/calibration/next_pose.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "common/rng.h"
#include "perception/calibration/calibration_target.h"
#include "perception/calibration/hand_pose_candidates.h"
#include "perception/calibration/pose_adjustment.h"

namespace vantage {
namespace {

using Matrix12 = Eigen::Matrix<double, 12, 12>;
using Vector12 = Eigen::Matrix<double, 12, 1>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

const HandEyeNoise kNoise;

/// A camera on a hand before a target on a table.
struct Cell {
  HandEyeSetup setup = HandEyeSetup::kEyeInHand;
  Pose T_x = Eigen::Translation3d(0.03, -0.06, 0.05) *
             Eigen::AngleAxisd(0.4, Eigen::Vector3d(0.2, 0.1, 1.0).normalized());
  Pose T_y = Eigen::Translation3d(0.5, 0.1, 0.0) *
             Eigen::AngleAxisd(180.0 * kDegree, Eigen::Vector3d::UnitX());
  Pose T_base_start;
  CalibrationTarget target{.columns = 4, .rows = 4};
  std::vector<Eigen::Vector3d> points = TargetPoints(target);

  explicit Cell(HandEyeSetup which) : setup(which) {
    const Pose B =
        Eigen::Translation3d(0.0, 0.0, 0.5) * Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX());
    T_base_start = EquationOfHand(setup, T_y * (T_x * B).inverse(Eigen::Isometry));
  }
  [[nodiscard]] Pose CameraTarget(const Pose& T_base_hand) const {
    return (EquationOfHand(setup, T_base_hand) * T_x).inverse(Eigen::Isometry) * T_y;
  }
  [[nodiscard]] std::vector<Pose> Candidates() const {
    return HandPoseCandidates(setup, T_x, T_y, 0.5, T_base_start, HandPoseLimits{});
  }
};

AdjustmentView ViewFrom(const Cell& cell, const Pose& T_base_hand) {
  AdjustmentView view;
  view.T_base_hand = T_base_hand;
  view.T_camera_target = cell.CameraTarget(T_base_hand);
  Vector6 sigmas;
  sigmas << Eigen::Vector3d::Constant(kNoise.camera_rotation),
      Eigen::Vector3d::Constant(kNoise.camera_translation);
  view.camera_covariance = sigmas.cwiseAbs2().asDiagonal();
  return view;
}

/// What a view tells of X and Y, by differences of the residual.
Matrix12 Information(const Cell& cell, const AdjustmentView& view) {
  AdjustmentProblem problem;
  problem.setup = cell.setup;
  problem.noise.robot_rotation = kNoise.robot_rotation;
  problem.noise.robot_translation = kNoise.robot_translation;
  AdjustmentState state;
  state.transforms = {cell.T_x, cell.T_y};
  Eigen::Matrix<double, 6, 12> J;
  for (int i = 0; i < 12; ++i) {
    const double step = 1e-6;
    const Vector12 move = step * Vector12::Unit(i);
    J.col(i) = (ViewError(cell.setup, view, Moved(problem, state, move)) -
                ViewError(cell.setup, view, Moved(problem, state, -move))) /
               (2.0 * step);
  }
  return J.transpose() * ViewErrorCovariance(problem, view, state).llt().solve(J);
}

HandEyeResult ResultWith(const Cell& cell, const Matrix12& covariance) {
  HandEyeResult result;
  result.setup = cell.setup;
  result.T_x = cell.T_x;
  result.T_y = cell.T_y;
  result.covariance = covariance.topLeftCorner<6, 6>();
  result.target_covariance = covariance.bottomRightCorner<6, 6>();
  result.cross_covariance = covariance.topRightCorner<6, 6>();
  return result;
}

double Sigma(const Matrix12& covariance, double lever) {
  return std::sqrt(lever * lever * covariance.topLeftCorner<3, 3>().trace() +
                   covariance.block<3, 3>(3, 3).trace());
}

TEST(RankNextPoses, PredictsTheCovarianceThatTheViewWouldGive) {
  for (const HandEyeSetup setup : {HandEyeSetup::kEyeInHand, HandEyeSetup::kEyeToHand}) {
    const Cell cell(setup);
    const std::vector<Pose> candidates = cell.Candidates();
    ASSERT_GT(candidates.size(), 50U);
    Matrix12 information = Matrix12::Zero();
    for (size_t i = 0; i < candidates.size(); i += candidates.size() / 5) {
      information += Information(cell, ViewFrom(cell, candidates[i]));
    }
    const Matrix12 covariance = information.ldlt().solve(Matrix12::Identity());
    // Without points the camera's noise is that of HandEyeNoise, as here.
    const std::vector<NextPose> ranked =
        RankNextPoses(ResultWith(cell, covariance), candidates, CameraModel{}, {}, kNoise, 0.5);
    ASSERT_EQ(ranked.size(), candidates.size());
    for (const NextPose& next : ranked) {
      ASSERT_TRUE(next.sees_target);
      const Matrix12 after =
          (information + Information(cell, ViewFrom(cell, candidates[next.candidate])))
              .ldlt()
              .solve(Matrix12::Identity());
      EXPECT_NEAR(next.expected_sigma, Sigma(after, 0.5), 1e-4 * Sigma(after, 0.5));
      EXPECT_LT(next.expected_sigma, Sigma(covariance, 0.5));
    }
    EXPECT_TRUE(std::ranges::is_sorted(ranked, {}, &NextPose::expected_sigma));
    EXPECT_LT(ranked.front().expected_sigma, 0.97 * ranked.back().expected_sigma);
  }
}

TEST(RankNextPoses, AfterTurnsAboutOneAxisAsksForAnother) {
  const Cell cell(HandEyeSetup::kEyeInHand);
  Matrix12 information = 1e-4 * Matrix12::Identity();  // Hardly anything is known of the rest.
  std::vector<Pose> turns;
  for (const double angle : {-0.5, -0.25, 0.0, 0.25, 0.5}) {
    turns.push_back(cell.T_base_start * Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()));
    information += Information(cell, ViewFrom(cell, turns.back()));
  }
  const Matrix12 covariance = information.ldlt().solve(Matrix12::Identity());
  const std::vector<Pose> candidates = {
      cell.T_base_start * Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitZ()),
      cell.T_base_start * Eigen::AngleAxisd(0.25, Eigen::Vector3d::UnitX())};
  const std::vector<NextPose> ranked =
      RankNextPoses(ResultWith(cell, covariance), candidates, CameraModel{}, {}, kNoise, 0.5);
  EXPECT_EQ(ranked.front().candidate, 1U);
  EXPECT_LT(ranked.front().expected_sigma, 0.1 * ranked.back().expected_sigma);
}

TEST(RankNextPoses, PosesThatDoNotSeeTheWholeTargetComeLast) {
  const Cell cell(HandEyeSetup::kEyeInHand);
  const auto from = [&](const Pose& T_camera_target) -> Pose {
    return cell.T_y * (cell.T_x * T_camera_target).inverse(Eigen::Isometry);
  };
  const std::vector<Pose> candidates = {
      from(Pose(Eigen::Translation3d(0.0, 0.0, 0.12))),  // Larger than the image.
      from(Pose(Eigen::Translation3d(0.0, 0.0, -0.5))),  // Behind.
      from(Pose(Eigen::Translation3d(0.22, 0.0, 0.5))),  // Over the border.
      from(Eigen::Translation3d(0.0, 0.0, 0.5) *         // From the back.
           Eigen::AngleAxisd(3.0, Eigen::Vector3d::UnitX())),
      from(Pose(Eigen::Translation3d(0.0, 0.0, 0.5)))};
  HandEyeResult result = ResultWith(cell, 1e-4 * Matrix12::Identity());
  const std::vector<NextPose> ranked =
      RankNextPoses(result, candidates, CameraModel{}, cell.points, kNoise);
  EXPECT_EQ(ranked[0].candidate, 4U);
  EXPECT_TRUE(ranked[0].sees_target);
  for (size_t i = 1; i < ranked.size(); ++i) {
    EXPECT_FALSE(ranked[i].sees_target);
    EXPECT_EQ(ranked[i].candidate, i - 1);
    EXPECT_GT(ranked[i].expected_sigma, ranked[0].expected_sigma);
  }
  EXPECT_TRUE(RankNextPoses(result, {}, CameraModel{}, cell.points, kNoise).empty());
}

TEST(RankNextPoses, PixelsTellWhatTheyTell) {
  // A point's information is that of its pixels: half their noise, and an exact robot, halves it.
  const Cell cell(HandEyeSetup::kEyeInHand);
  HandEyeNoise noise;
  noise.robot_rotation = 1e-9;
  noise.robot_translation = 1e-9;
  HandEyeResult result = ResultWith(cell, Matrix12::Identity());
  result.target_covariance.setZero();  // Then X follows from one view.
  const std::vector<Pose> candidates = {cell.T_base_start};
  noise.pixel = 0.4;
  const double coarse =
      RankNextPoses(result, candidates, CameraModel{}, cell.points, noise)[0].expected_sigma;
  noise.pixel = 0.2;
  const double fine =
      RankNextPoses(result, candidates, CameraModel{}, cell.points, noise)[0].expected_sigma;
  EXPECT_NEAR(coarse / fine, 2.0, 1e-3);
}

TEST(HandPoseCandidates, KeepTheirLimitsAndSeeTheTarget) {
  for (const HandEyeSetup setup : {HandEyeSetup::kEyeInHand, HandEyeSetup::kEyeToHand}) {
    const Cell cell(setup);
    const HandPoseLimits limits{.distance = 0.25, .turn = 40.0 * kDegree};
    const std::vector<Pose> few =
        HandPoseCandidates(setup, cell.T_x, cell.T_y, 0.5, cell.T_base_start, limits);
    EXPECT_GT(few.size(), 5U);
    EXPECT_LT(few.size(), cell.Candidates().size());
    for (const Pose& pose : few) {
      EXPECT_LE((pose.translation() - cell.T_base_start.translation()).norm(), 0.25 + 1e-9);
      EXPECT_LE(GeodesicAngle(Eigen::Quaterniond(pose.linear()),
                              Eigen::Quaterniond(cell.T_base_start.linear())),
                40.0 * kDegree + 1e-9);
      const Pose B = cell.CameraTarget(pose);
      EXPECT_NEAR(B.translation().head<2>().norm(), 0.0, 1e-9);
      EXPECT_GT(B.linear()(2, 2), 0.7);
    }
  }
}

TEST(FirstHandPoses, TurnInPlaceAboutAllAxes) {
  const Cell cell(HandEyeSetup::kEyeInHand);
  const std::vector<Pose> poses = FirstHandPoses(cell.T_base_start, 0.2);
  ASSERT_EQ(poses.size(), 6U);
  Eigen::Vector3d axes = Eigen::Vector3d::Zero();
  for (const Pose& pose : poses) {
    EXPECT_TRUE(pose.translation().isApprox(cell.T_base_start.translation(), 1e-12));
    const Eigen::Vector3d turn =
        LogSo3(Eigen::Quaterniond(cell.T_base_start.linear().transpose() * pose.linear()));
    EXPECT_NEAR(turn.norm(), 0.2, 1e-9);
    axes += turn.cwiseAbs();
  }
  EXPECT_TRUE(axes.isApprox(Eigen::Vector3d::Constant(0.4), 1e-9));
}

}  // namespace
}  // namespace vantage
