#include "perception/calibration/reprojection_adjustment.h"

#include <memory>

#include "perception/calibration/reprojection_cost.h"

namespace vantage {
namespace {

constexpr int kMostIterations = 50;

/// A pose as Ceres moves it: quaternion x, y, z, w, then translation, in one block, since a view's
/// pose is eliminated as a whole.
using PoseBlock = Eigen::Matrix<double, 7, 1>;
using PoseManifold =
    ceres::ProductManifold<ceres::EigenQuaternionManifold, ceres::EuclideanManifold<3>>;

PoseBlock ToBlock(const Pose& pose) {
  PoseBlock block;
  block << Eigen::Quaterniond(pose.linear()).coeffs(), pose.translation();
  return block;
}

Pose ToPose(const PoseBlock& block) {
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::Quaterniond(block.head<4>()).normalized().toRotationMatrix();
  pose.translation() = block.tail<3>();
  return pose;
}

/// What a parameter is not expected to be off by.
struct LoosePrior {
  template <class T>
  bool operator()(const T* values, T* residuals) const {
    for (int i = 0; i < 4; ++i) residuals[i] = (values[i] - expected[i]) / sigma[i];
    return true;
  }

  Eigen::Vector4d expected;
  Eigen::Vector4d sigma;
};

constexpr double kScaleSigma = 1.0;
constexpr double kOffsetSigma = 1.0;  // s

/// px: lens makers' focal lengths are right within far less, principal points lie in the middle.
Eigen::Vector4d PinholeSigma(const CameraModel& camera) {
  return {0.1 * camera.fx, 0.1 * camera.fy, 0.05 * camera.width, 0.05 * camera.width};
}

const Eigen::Vector4d kDistortionSigma(1.0, 2.0, 0.1, 0.1);

/// The parameters of a state, and the Ceres problem that points to them.
class ReprojectionBlocks {
 public:
  ReprojectionBlocks(const ReprojectionProblem& problem,
                     const ReprojectionNoise& noise,
                     const ReprojectionState& state)
      : problem_(problem),
        x_(ToBlock(state.transforms.T_x)),
        y_(ToBlock(state.transforms.T_y)),
        robot_scale_(state.robot_scale),
        time_offset_(state.time_offset),
        pinhole_(state.camera.fx, state.camera.fy, state.camera.cx, state.camera.cy),
        lens_(state.distortion.k1, state.distortion.k2, state.distortion.p1, state.distortion.p2),
        ceres_(Options()) {
    for (const Pose& pose : state.T_camera_target) poses_.push_back(ToBlock(pose));
    AddPose(&x_);
    AddPose(&y_);
    for (size_t i = 0; i < poses_.size(); ++i) AddView(i, noise, state.distortion.k3);
    ceres_.AddResidualBlock(
        Prior(PinholeOf(problem.expected_camera), PinholeSigma(problem.expected_camera)),
        nullptr,
        pinhole_.data());
    ceres_.AddResidualBlock(
        Prior(Eigen::Vector4d::Zero(), kDistortionSigma), nullptr, lens_.data());
    if (!problem.estimates_robot_scale) ceres_.SetParameterBlockConstant(&robot_scale_);
    if (problem.trajectory == nullptr) ceres_.SetParameterBlockConstant(&time_offset_);
    if (!problem.estimates_pinhole) ceres_.SetParameterBlockConstant(pinhole_.data());
    if (!problem.estimates_distortion) ceres_.SetParameterBlockConstant(lens_.data());
  }

  bool Solve() {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_SCHUR;
    options.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    for (PoseBlock& pose : poses_) {
      options.linear_solver_ordering->AddElementToGroup(pose.data(), 0);
    }
    for (double* block : SharedBlocks()) {
      options.linear_solver_ordering->AddElementToGroup(block, 1);
    }
    options.max_num_iterations = kMostIterations;
    options.function_tolerance = 1e-10;
    options.parameter_tolerance = 1e-11;
    options.num_threads = 1;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &ceres_, &summary);
    return summary.IsSolutionUsable();
  }

  void Store(ReprojectionState* state) const {
    state->transforms = {ToPose(x_), ToPose(y_)};
    state->robot_scale = robot_scale_;
    state->time_offset = time_offset_;
    state->camera.fx = pinhole_[0];
    state->camera.fy = pinhole_[1];
    state->camera.cx = pinhole_[2];
    state->camera.cy = pinhole_[3];
    state->distortion.k1 = lens_[0];
    state->distortion.k2 = lens_[1];
    state->distortion.p1 = lens_[2];
    state->distortion.p2 = lens_[3];
    for (size_t i = 0; i < poses_.size(); ++i) state->T_camera_target[i] = ToPose(poses_[i]);
  }

  std::vector<ViewEquations> Linearize() {
    std::vector<ViewEquations> views;
    for (size_t i = 0; i < poses_.size(); ++i) {
      ViewEquations view{.pixels = Evaluate(i, residuals_[i].pixels),
                         .robot_rotation = Evaluate(i, residuals_[i].rotation),
                         .robot_translation = Evaluate(i, residuals_[i].translation)};
      for (const double weight : problem_.views[i].weights) view.num_pixels += 2.0 * weight;
      views.push_back(std::move(view));
    }
    return views;
  }

 private:
  struct ViewResiduals {
    ceres::ResidualBlockId pixels;
    ceres::ResidualBlockId rotation;
    ceres::ResidualBlockId translation;
  };

  static ceres::Problem::Options Options() {
    ceres::Problem::Options options;
    options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    return options;
  }

  static Eigen::Vector4d PinholeOf(const CameraModel& camera) {
    return {camera.fx, camera.fy, camera.cx, camera.cy};
  }

  static ceres::CostFunction* Prior(const Eigen::Vector4d& expected, const Eigen::Vector4d& sigma) {
    return new ceres::AutoDiffCostFunction<LoosePrior, 4, 4>(new LoosePrior{expected, sigma});
  }

  void AddPose(PoseBlock* pose) { ceres_.AddParameterBlock(pose->data(), 7, &manifold_); }

  void AddView(size_t i, const ReprojectionNoise& noise, double k3) {
    AddPose(&poses_[i]);
    double* pose = poses_[i].data();
    const ReprojectionView& view = problem_.views[i];
    const auto add_robot = [&](RobotCost::Part part, double sigma) {
      return ceres_.AddResidualBlock(new ceres::AutoDiffCostFunction<RobotCost, 3, 7, 7, 7, 1, 1>(
                                         new RobotCost(part, problem_, view, sigma)),
                                     nullptr,
                                     x_.data(),
                                     y_.data(),
                                     pose,
                                     &robot_scale_,
                                     &time_offset_);
    };
    residuals_.push_back(
        {ceres_.AddResidualBlock(
             new PixelCost(view, noise.pixel, k3), nullptr, pose, pinhole_.data(), lens_.data()),
         add_robot(RobotCost::Part::kRotation, noise.robot_rotation),
         add_robot(RobotCost::Part::kTranslation, noise.robot_translation)});
  }

  std::vector<double*> SharedBlocks() {
    return {x_.data(), y_.data(), &robot_scale_, &time_offset_, pinhole_.data(), lens_.data()};
  }

  ViewEquations::Part Evaluate(size_t view, ceres::ResidualBlockId residual) {
    ceres::Problem::EvaluateOptions options;
    options.num_threads = 1;
    options.residual_blocks = {residual};
    options.parameter_blocks = {poses_[view].data()};
    for (double* block : SharedBlocks()) {
      if (!ceres_.IsParameterBlockConstant(block)) options.parameter_blocks.push_back(block);
    }
    std::vector<double> residuals;
    ceres::CRSMatrix sparse;
    double cost = 0.0;
    const bool is_done = ceres_.Evaluate(options, &cost, &residuals, nullptr, &sparse);
    VANTAGE_CHECK(is_done, "a view is linearized where it was adjusted");
    Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(sparse.num_rows, sparse.num_cols);
    for (size_t row = 0; row + 1 < sparse.rows.size(); ++row) {
      for (int i = sparse.rows[row]; i < sparse.rows[row + 1]; ++i) {
        jacobian(static_cast<Eigen::Index>(row), sparse.cols[static_cast<size_t>(i)]) =
            sparse.values[static_cast<size_t>(i)];
      }
    }
    // The manifold's tangent vector is half the rotation vector.
    for (const Eigen::Index rotation : {0, 6, 12}) jacobian.middleCols<3>(rotation) *= 0.5;
    const Eigen::Map<const Eigen::VectorXd> r(residuals.data(),
                                              static_cast<Eigen::Index>(residuals.size()));
    return {jacobian.transpose() * jacobian, jacobian.transpose() * r, r.squaredNorm()};
  }

  const ReprojectionProblem& problem_;
  PoseBlock x_;
  PoseBlock y_;
  double robot_scale_;
  double time_offset_;
  Eigen::Vector4d pinhole_;
  Eigen::Vector4d lens_;
  std::vector<PoseBlock> poses_;
  std::vector<ViewResiduals> residuals_;
  PoseManifold manifold_;
  ceres::Problem ceres_;
};

}  // namespace

bool AdjustReprojection(const ReprojectionProblem& problem,
                        const ReprojectionNoise& noise,
                        ReprojectionState* state) {
  ReprojectionBlocks blocks(problem, noise, *state);
  if (!blocks.Solve()) return false;
  blocks.Store(state);
  return true;
}

std::vector<ViewEquations> LinearizeReprojection(const ReprojectionProblem& problem,
                                                 const ReprojectionState& state) {
  const ReprojectionNoise unit{.pixel = 1.0, .robot_rotation = 1.0, .robot_translation = 1.0};
  return ReprojectionBlocks(problem, unit, state).Linearize();
}

ReprojectionState MovedShared(const ReprojectionProblem& problem,
                              const ReprojectionState& state,
                              const Eigen::VectorXd& step) {
  ReprojectionState moved = state;
  Eigen::Index next = 0;
  for (Pose* pose : {&moved.transforms.T_x, &moved.transforms.T_y}) {
    pose->linear() = ExpSo3(step.segment<3>(next)) * pose->linear();
    pose->translation() += step.segment<3>(next + 3);
    next += 6;
  }
  const auto move = [&](bool is_asked, std::initializer_list<double*> values) {
    if (!is_asked) return;
    for (double* value : values) *value += step[next++];
  };
  CameraModel& camera = moved.camera;
  LensDistortion& lens = moved.distortion;
  move(problem.estimates_robot_scale, {&moved.robot_scale});
  move(problem.trajectory != nullptr, {&moved.time_offset});
  move(problem.estimates_pinhole, {&camera.fx, &camera.fy, &camera.cx, &camera.cy});
  move(problem.estimates_distortion, {&lens.k1, &lens.k2, &lens.p1, &lens.p2});
  return moved;
}

Eigen::VectorXd PriorInformation(const ReprojectionProblem& problem) {
  std::vector<double> information(12, 0.0);
  const auto add = [&information](bool is_asked, const Eigen::VectorXd& sigma) {
    if (!is_asked) return;
    for (const double value : sigma) information.push_back(1.0 / (value * value));
  };
  add(problem.estimates_robot_scale, Eigen::VectorXd::Constant(1, kScaleSigma));
  add(problem.trajectory != nullptr, Eigen::VectorXd::Constant(1, kOffsetSigma));
  add(problem.estimates_pinhole, PinholeSigma(problem.expected_camera));
  add(problem.estimates_distortion, kDistortionSigma);
  return Eigen::Map<const Eigen::VectorXd>(information.data(),
                                           static_cast<Eigen::Index>(information.size()));
}

}  // namespace vantage
