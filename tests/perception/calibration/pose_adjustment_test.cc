#include "perception/calibration/pose_adjustment.h"

#include <ceres/ceres.h>
#include <ceres/gradient_checker.h>
#include <gtest/gtest.h>

#include "perception/calibration/pose_residual.h"
#include "tests/perception/calibration/simulated_pose_views.h"

namespace vantage {
namespace {

constexpr HandEyeSetup kSetups[] = {HandEyeSetup::kEyeInHand, HandEyeSetup::kEyeToHand};

AdjustmentView RandomView(Rng& rng) {
  AdjustmentView view;
  view.T_base_hand = MakePose(rng.Rotation(), rng.UnitVector());
  view.T_camera_target = MakePose(rng.Rotation(), rng.UnitVector());
  view.angular_velocity = rng.UnitVector();
  view.velocity = rng.UnitVector();
  Eigen::Matrix<double, 6, 1> sigma;
  sigma << NormalVector(0.01, rng), NormalVector(0.01, rng);
  view.camera_covariance =
      1e-6 * HandEyeCovariance::Identity() + sigma * sigma.transpose();  // Correlated.
  return view;
}

AdjustmentState RandomState(Rng& rng) {
  return {{MakePose(rng.Rotation(), rng.UnitVector()), MakePose(rng.Rotation(), rng.UnitVector())},
          rng.Uniform(0.9, 1.1),
          rng.Uniform(-0.2, 0.2)};
}

AdjustmentProblem FullProblem(HandEyeSetup setup) {
  AdjustmentProblem problem;
  problem.setup = setup;
  problem.noise.robot_rotation = 0.003;
  problem.noise.robot_translation = 0.002;
  problem.estimates_robot_scale = true;
  problem.estimates_time_offset = true;
  return problem;
}

TEST(PoseAdjustment, DerivativesAreThoseOfDifferences) {
  Rng rng(1);
  for (const HandEyeSetup setup : kSetups) {
    for (int trial = 0; trial < 10; ++trial) {
      const AdjustmentView view = RandomView(rng);
      AdjustmentState state = RandomState(rng);
      // Within some 0.5 rad of its place, away from half a turn where the logarithm jumps.
      state.transforms.T_y = EquationOfHand(setup, view.T_base_hand) * state.transforms.T_x *
                             view.T_camera_target *
                             MakePose(ExpSo3(0.5 * rng.UnitVector()), rng.UnitVector());
      ceres::AutoDiffCostFunction<PoseResidual, 6, 4, 3, 4, 3, 1, 1> cost(
          new PoseResidual(setup, view, HandEyeCovariance::Identity()));
      const ceres::EigenQuaternionManifold quaternion;
      const std::vector<const ceres::Manifold*> manifolds = {
          &quaternion, nullptr, &quaternion, nullptr, nullptr, nullptr};
      ceres::NumericDiffOptions options;
      ceres::GradientChecker checker(&cost, &manifolds, options);
      Eigen::Quaterniond q_x(state.transforms.T_x.linear());
      Eigen::Quaterniond q_y(state.transforms.T_y.linear());
      Eigen::Vector3d t_x = state.transforms.T_x.translation();
      Eigen::Vector3d t_y = state.transforms.T_y.translation();
      const double* parameters[] = {q_x.coeffs().data(),
                                    t_x.data(),
                                    q_y.coeffs().data(),
                                    t_y.data(),
                                    &state.robot_scale,
                                    &state.time_offset};
      ceres::GradientChecker::ProbeResults results;
      EXPECT_TRUE(checker.Probe(parameters, 1e-6, &results)) << results.error_log;
    }
  }
}

TEST(PoseAdjustment, LinearizationIsThatOfMoved) {
  Rng rng(2);
  for (const HandEyeSetup setup : kSetups) {
    const AdjustmentProblem problem = FullProblem(setup);
    const AdjustmentView view = RandomView(rng);
    const AdjustmentState state = RandomState(rng);
    const AdjustmentLinearization made = Linearize(problem, {&view, 1}, state);
    ASSERT_EQ(made.jacobian.cols(), 14);
    const HandEyeCovariance covariance = ViewErrorCovariance(problem, view, state);
    const HandEyeCovariance factor = covariance.llt().matrixL();
    EXPECT_LT((factor * made.residuals - ViewError(setup, view, state)).norm(), 1e-9);
    constexpr double kStep = 1e-6;
    for (int axis = 0; axis < 14; ++axis) {
      const Eigen::VectorXd step = kStep * Eigen::VectorXd::Unit(14, axis);
      const Eigen::Matrix<double, 6, 1> numeric =
          (ViewError(setup, view, Moved(problem, state, step)) -
           ViewError(setup, view, Moved(problem, state, -step))) /
          (2.0 * kStep);
      EXPECT_LT((factor * made.jacobian.col(axis) - numeric).norm(), 1e-6) << axis;
    }
  }
}

// The covariance of a view's error is that of errors drawn from the noise.
TEST(PoseAdjustment, ErrorCovarianceIsThatOfSamples) {
  for (const HandEyeSetup setup : kSetups) {
    Rng rng(3);
    AdjustmentProblem problem = FullProblem(setup);
    problem.noise.scales = {2.0, 0.5};
    AdjustmentState state = RandomState(rng);
    state.robot_scale = 1.0;
    state.time_offset = 0.0;
    AdjustmentView view = RandomView(rng);
    const Pose A = EquationOfHand(setup, view.T_base_hand);
    state.transforms.T_y = A * state.transforms.T_x * view.T_camera_target;
    Eigen::Matrix<double, 6, 1> scale;
    scale << 2.0, 2.0, 2.0, 0.5, 0.5, 0.5;
    const HandEyeCovariance camera =
        scale.asDiagonal() * view.camera_covariance * scale.asDiagonal();
    const HandEyeCovariance factor = camera.llt().matrixL();
    HandEyeCovariance sum = HandEyeCovariance::Zero();
    constexpr int kSamples = 40000;
    for (int i = 0; i < kSamples; ++i) {
      AdjustmentView noisy = view;
      noisy.T_base_hand = Disturbed(view.T_base_hand, 2.0 * 0.003, 0.5 * 0.002, rng);
      Eigen::Matrix<double, 6, 1> error;
      error << NormalVector(1.0, rng), NormalVector(1.0, rng);
      error = factor * error;
      noisy.T_camera_target.linear() = ExpSo3(error.head<3>()) * view.T_camera_target.linear();
      noisy.T_camera_target.translation() += error.tail<3>();
      const Eigen::Matrix<double, 6, 1> residual = ViewError(setup, noisy, state);
      sum += residual * residual.transpose() / kSamples;
    }
    const HandEyeCovariance expected = ViewErrorCovariance(problem, view, state);
    const HandEyeCovariance whitened = expected.llt().matrixL().solve(sum) * expected.inverse() *
                                       HandEyeCovariance(expected.llt().matrixL());
    EXPECT_LT((whitened - HandEyeCovariance::Identity()).cwiseAbs().maxCoeff(), 0.05);
  }
}

}  // namespace
}  // namespace vantage
