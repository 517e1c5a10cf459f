#include "tools/evaluate/handeye_methods.h"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <opencv2/calib3d.hpp>

#include "perception/calibration/closed_form.h"
#include "perception/calibration/pose_adjustment.h"
#include "perception/calibration/pose_residual.h"

namespace vantage {
namespace {

using MatrixList = std::vector<cv::Mat>;

void Append(const Pose& pose, MatrixList* rotations, MatrixList* translations) {
  cv::Mat rotation(3, 3, CV_64F);
  cv::Mat translation(3, 1, CV_64F);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      rotation.at<double>(row, column) = pose.linear()(row, column);
    }
    translation.at<double>(row) = pose.translation()[row];
  }
  rotations->push_back(rotation);
  translations->push_back(translation);
}

std::optional<Pose> ReadPose(const cv::Mat& rotation, const cv::Mat& translation) {
  if (rotation.rows != 3 || rotation.cols != 3 || translation.total() != 3) return std::nullopt;
  Pose pose = Pose::Identity();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      pose.linear()(row, column) = rotation.at<double>(row, column);
    }
    pose.translation()[row] = translation.at<double>(row);
  }
  if (!pose.matrix().allFinite()) return std::nullopt;
  return pose;
}

/// Eye to hand is given as OpenCV's documentation says: hands inverted.
std::optional<Pose> CalibrateHandEye(cv::HandEyeCalibrationMethod method,
                                     HandEyeSetup setup,
                                     std::span<const PoseView> views) {
  MatrixList R_hand, t_hand, R_target, t_target;
  for (const PoseView& view : views) {
    Append(EquationOfHand(setup, view.T_base_hand), &R_hand, &t_hand);
    Append(view.T_camera_target, &R_target, &t_target);
  }
  cv::Mat R, t;
  try {
    cv::calibrateHandEye(R_hand, t_hand, R_target, t_target, R, t, method);
  } catch (const cv::Exception&) {
    return std::nullopt;
  }
  return ReadPose(R, t);
}

std::optional<Pose> CalibrateRobotWorld(cv::RobotWorldHandEyeCalibrationMethod method,
                                        HandEyeSetup setup,
                                        std::span<const PoseView> views) {
  MatrixList R_hand, t_hand, R_target, t_target;
  for (const PoseView& view : views) {
    Append(EquationOfHand(setup, view.T_base_hand).inverse(), &R_hand, &t_hand);
    Append(view.T_camera_target, &R_target, &t_target);
  }
  cv::Mat R_y, t_y, R, t;
  try {
    cv::calibrateRobotWorldHandEye(R_target, t_target, R_hand, t_hand, R_y, t_y, R, t, method);
  } catch (const cv::Exception&) {
    return std::nullopt;
  }
  const std::optional<Pose> T_camera_x = ReadPose(R, t);
  if (!T_camera_x) return std::nullopt;
  return T_camera_x->inverse();
}

ceres::CostFunction* MakeCost(HandEyeSetup setup,
                              const PoseView& view,
                              const HandEyeNoise& noise,
                              const HandEyeTransforms& start) {
  AdjustmentView adjusted;
  adjusted.T_base_hand = view.T_base_hand;
  adjusted.T_camera_target = view.T_camera_target;
  Eigen::Matrix<double, 6, 1> sigma;
  sigma << Eigen::Vector3d::Constant(noise.camera_rotation),
      Eigen::Vector3d::Constant(noise.camera_translation);
  adjusted.camera_covariance = sigma.cwiseAbs2().asDiagonal();
  AdjustmentProblem weights;
  weights.setup = setup;
  weights.noise = {noise.robot_rotation, noise.robot_translation, {}};
  const Eigen::LLT<HandEyeCovariance> covariance(
      ViewErrorCovariance(weights, adjusted, {start, 1.0, 0.0}));
  return new ceres::AutoDiffCostFunction<PoseResidual, 6, 4, 3, 4, 3, 1, 1>(
      new PoseResidual(setup, adjusted, covariance.matrixL().solve(HandEyeCovariance::Identity())));
}

std::optional<Pose> CalibrateWithCauchy(HandEyeSetup setup,
                                        std::span<const PoseView> views,
                                        const HandEyeNoise& noise) {
  std::vector<HandEyeEquation> equations;
  for (const PoseView& view : views) {
    equations.push_back({EquationOfHand(setup, view.T_base_hand), view.T_camera_target});
  }
  const std::optional<HandEyeTransforms> start = SolvePark(equations);
  if (!start) return std::nullopt;
  Eigen::Quaterniond q_x(start->T_x.linear());
  Eigen::Quaterniond q_y(start->T_y.linear());
  Eigen::Vector3d t_x = start->T_x.translation();
  Eigen::Vector3d t_y = start->T_y.translation();
  double scale = 1.0;
  double offset = 0.0;
  ceres::Problem problem;
  double* const parameters[] = {
      q_x.coeffs().data(), t_x.data(), q_y.coeffs().data(), t_y.data(), &scale, &offset};
  for (const PoseView& view : views) {
    problem.AddResidualBlock(
        MakeCost(setup, view, noise, *start), new ceres::CauchyLoss(1.0), parameters, 6);
  }
  problem.SetManifold(parameters[0], new ceres::EigenQuaternionManifold);
  problem.SetManifold(parameters[2], new ceres::EigenQuaternionManifold);
  problem.SetParameterBlockConstant(&scale);
  problem.SetParameterBlockConstant(&offset);
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_QR;
  solver.max_num_iterations = 200;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  Pose T_x = Pose::Identity();
  T_x.linear() = q_x.normalized().toRotationMatrix();
  T_x.translation() = t_x;
  return T_x;
}

HandEyeMethod OpenCvMethod(const char* id, const char* label, cv::HandEyeCalibrationMethod method) {
  return {id,
          label,
          [method](HandEyeSetup setup, std::span<const PoseView> views, const HandEyeNoise&) {
            return CalibrateHandEye(method, setup, views);
          }};
}

HandEyeMethod OpenCvMethod(const char* id,
                           const char* label,
                           cv::RobotWorldHandEyeCalibrationMethod method) {
  return {id,
          label,
          [method](HandEyeSetup setup, std::span<const PoseView> views, const HandEyeNoise&) {
            return CalibrateRobotWorld(method, setup, views);
          }};
}

}  // namespace

std::vector<HandEyeMethod> HandEyePeers() {
  return {{"cauchy", "Ceres, Cauchy loss, from Park", CalibrateWithCauchy},
          OpenCvMethod("tsai", "OpenCV, Tsai", cv::CALIB_HAND_EYE_TSAI),
          OpenCvMethod("park", "OpenCV, Park", cv::CALIB_HAND_EYE_PARK),
          OpenCvMethod("horaud", "OpenCV, Horaud", cv::CALIB_HAND_EYE_HORAUD),
          OpenCvMethod("andreff", "OpenCV, Andreff", cv::CALIB_HAND_EYE_ANDREFF),
          OpenCvMethod("daniilidis", "OpenCV, Daniilidis", cv::CALIB_HAND_EYE_DANIILIDIS),
          OpenCvMethod("shah", "OpenCV, Shah", cv::CALIB_ROBOT_WORLD_HAND_EYE_SHAH),
          OpenCvMethod("li", "OpenCV, Li", cv::CALIB_ROBOT_WORLD_HAND_EYE_LI)};
}

}  // namespace vantage
