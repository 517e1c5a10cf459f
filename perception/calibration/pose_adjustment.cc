#include "perception/calibration/pose_adjustment.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <Eigen/Cholesky>
#include <vector>

#include "common/check.h"
#include "perception/calibration/pose_residual.h"

namespace vantage {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kMostIterations = 20;

/// A Ceres problem with the parameters it points to.
class CeresProblem {
 public:
  CeresProblem(const AdjustmentProblem& problem,
               std::span<const AdjustmentView> views,
               const AdjustmentState& state)
      : asked_(problem),
        q_x_(state.transforms.T_x.linear()),
        q_y_(state.transforms.T_y.linear()),
        t_x_(state.transforms.T_x.translation()),
        t_y_(state.transforms.T_y.translation()),
        robot_scale_(state.robot_scale),
        time_offset_(state.time_offset),
        problem_(Options()) {
    for (const AdjustmentView& view : views) {
      const Eigen::LLT<HandEyeCovariance> covariance(ViewErrorCovariance(problem, view, state));
      const HandEyeCovariance whitening = covariance.matrixL().solve(HandEyeCovariance::Identity());
      auto* cost = new ceres::AutoDiffCostFunction<PoseResidual, 6, 4, 3, 4, 3, 1, 1>(
          new PoseResidual(problem.setup, view, whitening));
      problem_.AddResidualBlock(cost,
                                nullptr,
                                q_x_.coeffs().data(),
                                t_x_.data(),
                                q_y_.coeffs().data(),
                                t_y_.data(),
                                &robot_scale_,
                                &time_offset_);
    }
    problem_.SetManifold(q_x_.coeffs().data(), &manifold_);
    problem_.SetManifold(q_y_.coeffs().data(), &manifold_);
    if (!problem.estimates_robot_scale) problem_.SetParameterBlockConstant(&robot_scale_);
    if (!problem.estimates_time_offset) problem_.SetParameterBlockConstant(&time_offset_);
  }

  void Solve() {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_QR;
    options.max_num_iterations = kMostIterations;
    options.function_tolerance = 1e-12;
    options.gradient_tolerance = 1e-14;
    options.parameter_tolerance = 1e-12;
    options.num_threads = 1;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
  }

  [[nodiscard]] AdjustmentState State() const {
    AdjustmentState state;
    state.transforms.T_x.linear() = q_x_.normalized().toRotationMatrix();
    state.transforms.T_x.translation() = t_x_;
    state.transforms.T_y.linear() = q_y_.normalized().toRotationMatrix();
    state.transforms.T_y.translation() = t_y_;
    state.robot_scale = robot_scale_;
    state.time_offset = time_offset_;
    return state;
  }

  AdjustmentLinearization Evaluate() {
    ceres::Problem::EvaluateOptions options;
    options.num_threads = 1;
    options.parameter_blocks = {
        q_x_.coeffs().data(), t_x_.data(), q_y_.coeffs().data(), t_y_.data()};
    if (asked_.estimates_robot_scale) options.parameter_blocks.push_back(&robot_scale_);
    if (asked_.estimates_time_offset) options.parameter_blocks.push_back(&time_offset_);
    std::vector<double> residuals;
    ceres::CRSMatrix sparse;
    double cost = 0.0;
    const bool is_done = problem_.Evaluate(options, &cost, &residuals, nullptr, &sparse);
    VANTAGE_CHECK(is_done, "residuals are finite");
    AdjustmentLinearization made;
    made.residuals = Eigen::Map<const Eigen::VectorXd>(residuals.data(),
                                                       static_cast<Eigen::Index>(residuals.size()));
    made.jacobian = Eigen::MatrixXd::Zero(sparse.num_rows, sparse.num_cols);
    for (int row = 0; row < sparse.num_rows; ++row) {
      for (int i = sparse.rows[static_cast<size_t>(row)];
           i < sparse.rows[static_cast<size_t>(row) + 1];
           ++i) {
        made.jacobian(row, sparse.cols[static_cast<size_t>(i)]) =
            sparse.values[static_cast<size_t>(i)];
      }
    }
    // The manifold's tangent vector is half the rotation vector.
    made.jacobian.middleCols<3>(0) *= 0.5;
    made.jacobian.middleCols<3>(6) *= 0.5;
    return made;
  }

 private:
  static ceres::Problem::Options Options() {
    ceres::Problem::Options options;
    options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    return options;
  }

  AdjustmentProblem asked_;
  Eigen::Quaterniond q_x_;
  Eigen::Quaterniond q_y_;
  Vector3d t_x_;
  Vector3d t_y_;
  double robot_scale_;
  double time_offset_;
  ceres::EigenQuaternionManifold manifold_;
  ceres::Problem problem_;
};

/// The hand of a view by the state: its scale and its time.
Pose HandOf(const AdjustmentView& view, const AdjustmentState& state) {
  Pose T_base_hand = Pose::Identity();
  T_base_hand.linear() =
      ExpSo3(state.time_offset * view.angular_velocity) * view.T_base_hand.linear();
  T_base_hand.translation() =
      state.robot_scale * (view.T_base_hand.translation() + state.time_offset * view.velocity);
  return T_base_hand;
}

}  // namespace

Eigen::Matrix<double, 6, 1> ViewError(HandEyeSetup setup,
                                      const AdjustmentView& view,
                                      const AdjustmentState& state) {
  const Pose A = EquationOfHand(setup, HandOf(view, state));
  const Pose through = A * state.transforms.T_x * view.T_camera_target;
  Eigen::Matrix<double, 6, 1> error;
  error << LogSo3(Eigen::Quaterniond(through.linear() * state.transforms.T_y.linear().transpose())),
      through.translation() - state.transforms.T_y.translation();
  return error;
}

HandEyeCovariance ViewErrorCovariance(const AdjustmentProblem& problem,
                                      const AdjustmentView& view,
                                      const AdjustmentState& state) {
  const AdjustmentNoise& noise = problem.noise;
  const Pose A = EquationOfHand(problem.setup, HandOf(view, state));
  const Vector3d t = A * (state.transforms.T_x * view.T_camera_target.translation());
  // From the hand's origin, about which the robot's rotation acts, to the target (eye in hand) or
  // back from the camera's view of it.
  const Vector3d lever = problem.setup == HandEyeSetup::kEyeInHand ? t - A.translation() : t;
  Matrix3d cross;
  cross << 0.0, -lever.z(), lever.y(), lever.z(), 0.0, -lever.x(), -lever.y(), lever.x(), 0.0;
  const double rotation = noise.scales.rotation * noise.robot_rotation;
  const double translation = noise.scales.translation * noise.robot_translation;
  HandEyeCovariance covariance = HandEyeCovariance::Zero();
  covariance.topLeftCorner<3, 3>() = rotation * rotation * Matrix3d::Identity();
  covariance.topRightCorner<3, 3>() = rotation * rotation * cross;
  covariance.bottomLeftCorner<3, 3>() = rotation * rotation * cross.transpose();
  covariance.bottomRightCorner<3, 3>() = rotation * rotation * cross * cross.transpose() +
                                         translation * translation * Matrix3d::Identity();

  HandEyeCovariance turn = HandEyeCovariance::Zero();
  const Matrix3d R = A.linear() * state.transforms.T_x.linear();
  turn.topLeftCorner<3, 3>() = noise.scales.rotation * R;
  turn.bottomRightCorner<3, 3>() = noise.scales.translation * R;
  return covariance + turn * view.camera_covariance * turn.transpose();
}

AdjustmentLinearization Linearize(const AdjustmentProblem& problem,
                                  std::span<const AdjustmentView> views,
                                  const AdjustmentState& state) {
  return CeresProblem(problem, views, state).Evaluate();
}

AdjustmentState AdjustPoses(const AdjustmentProblem& problem,
                            std::span<const AdjustmentView> views,
                            const AdjustmentState& start) {
  CeresProblem ceres(problem, views, start);
  ceres.Solve();
  return ceres.State();
}

AdjustmentState Moved(const AdjustmentProblem& problem,
                      const AdjustmentState& state,
                      const Eigen::VectorXd& step) {
  AdjustmentState moved = state;
  const auto move = [&step](Eigen::Index at, Pose* pose) {
    pose->linear() = ExpSo3(step.segment<3>(at)) * pose->linear();
    pose->translation() += step.segment<3>(at + 3);
  };
  move(0, &moved.transforms.T_x);
  move(6, &moved.transforms.T_y);
  Eigen::Index next = 12;
  if (problem.estimates_robot_scale) moved.robot_scale += step[next++];
  if (problem.estimates_time_offset) moved.time_offset += step[next++];
  return moved;
}

}  // namespace vantage
