#include "perception/refinement/multi_view_problem.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/SparseCore>
#include <cmath>
#include <memory>

#include "common/check.h"

namespace vantage {
namespace {

template <class T>
using Matrix3 = Eigen::Matrix<T, 3, 3>;
template <class T>
using Vector3 = Eigen::Matrix<T, 3, 1>;

template <class T>
Matrix3<T> Exp(const T* rotation_vector) {
  Matrix3<T> R;
  ceres::AngleAxisToRotationMatrix(rotation_vector, R.data());
  return R;
}

// The root of a term: six residuals root * m - offset for a motion m.
struct Root {
  explicit Root(const ViewTerm& term) {
    constexpr double kRank = 1e-12;  // Of the largest eigenvalue.
    const Eigen::SelfAdjointEigenSolver<Matrix6> directions(term.information);
    const Vector6& values = directions.eigenvalues();
    for (int i = 0; i < 6; ++i) {
      if (!(values[i] > kRank * values[5])) continue;
      const Vector6 direction = directions.eigenvectors().col(i);
      matrix.row(i) = std::sqrt(values[i]) * direction.transpose();
      offset[i] = direction.dot(term.right) / std::sqrt(values[i]);
    }
  }
  Matrix6 matrix = Matrix6::Zero();
  Vector6 offset = Vector6::Zero();
};

class ViewResidual {
 public:
  ViewResidual(const ViewTerm& term, const Pose& T_world_camera, const Eigen::Vector3d& center)
      : root_(term),
        T_world_camera_(T_world_camera),
        R_drawn_(term.T_camera_object.linear()),
        center_drawn_(term.T_camera_object * center) {}

  template <class T>
  bool operator()(const T* q_world_object,
                  const T* p_world_center,
                  const T* camera,
                  const T* hand_eye,
                  const T* bias,
                  T* residuals) const {
    const Matrix3<T> R_world_hand = T_world_camera_.linear().cast<T>() * Exp(hand_eye);
    const Matrix3<T> R_world_camera = R_world_hand * Exp(camera);
    const Vector3<T> p_world_camera =
        T_world_camera_.translation().cast<T>() +
        T_world_camera_.linear().cast<T>() * Eigen::Map<const Vector3<T>>(hand_eye + 3) +
        R_world_hand * Eigen::Map<const Vector3<T>>(camera + 3);
    const Eigen::Map<const Eigen::Quaternion<T>> q(q_world_object);
    const Matrix3<T> turn =
        R_world_camera.transpose() * q.toRotationMatrix() * R_drawn_.transpose().cast<T>();
    Eigen::Matrix<T, 6, 1> motion;
    ceres::RotationMatrixToAngleAxis(turn.data(), motion.data());
    motion.template tail<3>() =
        R_world_camera.transpose() *
            (Eigen::Map<const Vector3<T>>(p_world_center) - p_world_camera) -
        center_drawn_.cast<T>();
    motion[0] += bias[0];
    motion[1] += bias[1];
    motion[5] += bias[2] * T(center_drawn_.z() * center_drawn_.z());
    Eigen::Map<Eigen::Matrix<T, 6, 1>> out(residuals);
    out = root_.matrix.cast<T>() * motion - root_.offset.cast<T>();
    return true;
  }

 private:
  Root root_;
  Pose T_world_camera_;
  Eigen::Matrix3d R_drawn_;
  Eigen::Vector3d center_drawn_;
};

// Numbers about 0, each by its standard deviation.
template <int kSize>
class AboutZero {
 public:
  explicit AboutZero(const Eigen::Matrix<double, kSize, 1>& sigmas)
      : inverse_(sigmas.cwiseInverse()) {}
  template <class T>
  bool operator()(const T* x, T* residuals) const {
    for (int i = 0; i < kSize; ++i) residuals[i] = inverse_[i] * x[i];
    return true;
  }

 private:
  Eigen::Matrix<double, kSize, 1> inverse_;
};

// Directions that no view fixes stay where they are.
class NearStart {
 public:
  NearStart(const Eigen::Quaterniond& q, const Eigen::Vector3d& p)
      : inverse_q_(q.conjugate()), p_(p) {}
  template <class T>
  bool operator()(const T* q_world_object, const T* p_world_center, T* residuals) const {
    constexpr double kRotation = 1.0;     // rad
    constexpr double kTranslation = 0.1;  // m
    const Eigen::Map<const Eigen::Quaternion<T>> q(q_world_object);
    const Matrix3<T> turn = (q * inverse_q_.cast<T>()).toRotationMatrix();
    ceres::RotationMatrixToAngleAxis(turn.data(), residuals);
    for (int i = 0; i < 3; ++i) {
      residuals[i] *= T(1.0 / kRotation);
      residuals[i + 3] = (p_world_center[i] - p_[i]) * T(1.0 / kTranslation);
    }
    return true;
  }

 private:
  Eigen::Quaterniond inverse_q_;
  Eigen::Vector3d p_;
};

Vector6 Sigmas(double rotation, double translation) {
  Vector6 sigmas;
  sigmas << Eigen::Vector3d::Constant(rotation), Eigen::Vector3d::Constant(translation);
  return sigmas;
}

// The state in the numbers that Ceres changes, and what it makes of them.
class CeresProblem {
 public:
  CeresProblem(const MultiViewProblem& problem, const MultiViewState& state)
      : centers_(problem.centers),
        camera_(state.camera),
        hand_eye_(state.hand_eye),
        bias_(state.bias),
        problem_(Options()) {
    const size_t objects = problem.centers.size();
    VANTAGE_CHECK(state.T_world_object.size() == objects &&
                      problem.T_world_object_start.size() == objects &&
                      state.camera.size() == problem.T_world_camera.size(),
                  "a pose and a start for each object, a motion for each camera");
    for (size_t i = 0; i < objects; ++i) {
      rotations_.push_back(Eigen::Quaterniond(state.T_world_object[i].linear()).normalized());
      positions_.push_back(state.T_world_object[i] * centers_[i]);
    }
    for (size_t i = 0; i < objects; ++i) AddObject(i, problem.T_world_object_start[i]);
    AddPrior(&camera_, Sigmas(problem.camera_rotation, problem.camera_translation));
    AddPrior(std::span(&hand_eye_, 1),
             Sigmas(problem.hand_eye_rotation, problem.hand_eye_translation));
    AddPrior(std::span(&bias_, 1),
             Eigen::Vector3d(problem.bias_tilt, problem.bias_tilt, problem.bias_at_1m));
    for (const ViewTerm& term : problem.terms) AddTerm(term, problem);
  }

  bool Solve() {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
    options.max_num_iterations = 10;
    options.function_tolerance = 1e-10;
    options.num_threads = 1;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    return summary.IsSolutionUsable();
  }

  MultiViewState State() const {
    MultiViewState state;
    for (size_t i = 0; i < centers_.size(); ++i) {
      Pose T = Pose::Identity();
      T.linear() = rotations_[i].normalized().toRotationMatrix();
      T.translation() = positions_[i] - T.linear() * centers_[i];
      state.T_world_object.push_back(T);
    }
    state.camera = camera_;
    state.hand_eye = hand_eye_;
    state.bias = bias_;
    return state;
  }

  // Of the objects' motions, others marginalized.
  bool Covariances(std::vector<Matrix6>* covariances) {
    ceres::CRSMatrix jacobian;
    std::vector<double*> blocks;
    for (size_t i = 0; i < centers_.size(); ++i) AppendObject(i, &blocks);
    for (Vector6& camera : camera_) AppendFree(camera.data(), &blocks);
    AppendFree(hand_eye_.data(), &blocks);
    AppendFree(bias_.data(), &blocks);
    ceres::Problem::EvaluateOptions options;
    options.parameter_blocks = blocks;
    if (!problem_.Evaluate(options, nullptr, nullptr, nullptr, &jacobian)) return false;
    const Eigen::Map<const Eigen::SparseMatrix<double, Eigen::RowMajor>> J(
        jacobian.num_rows,
        jacobian.num_cols,
        static_cast<Eigen::Index>(jacobian.values.size()),
        jacobian.rows.data(),
        jacobian.cols.data(),
        jacobian.values.data());
    const Eigen::MatrixXd information = Eigen::MatrixXd(J.transpose() * J);
    const Eigen::LLT<Eigen::MatrixXd> root(information);
    if (root.info() != Eigen::Success) return false;
    const Eigen::MatrixXd inverse =
        root.solve(Eigen::MatrixXd::Identity(information.rows(), information.cols()));
    covariances->clear();
    for (size_t i = 0; i < centers_.size(); ++i) {
      const auto first = static_cast<Eigen::Index>(6 * i);
      const Matrix6 block = Scale() * inverse.block<6, 6>(first, first) * Scale();
      covariances->push_back(0.5 * (block + block.transpose()));
    }
    return true;
  }

  double Cost(std::vector<Vector6>* by_objects, std::vector<Vector6>* by_cameras) {
    std::vector<double*> blocks;
    for (size_t i = 0; i < centers_.size(); ++i) AppendObject(i, &blocks);
    for (Vector6& camera : camera_) blocks.push_back(camera.data());
    ceres::Problem::EvaluateOptions options;
    options.parameter_blocks = blocks;
    double cost = 0.0;
    std::vector<double> gradient;
    problem_.Evaluate(options, &cost, nullptr, &gradient, nullptr);
    by_objects->clear();
    by_cameras->clear();
    for (size_t i = 0; 6 * i < gradient.size(); ++i) {
      const Vector6 block = Eigen::Map<const Vector6>(&gradient[6 * i]);
      if (i < centers_.size()) by_objects->push_back(Scale().inverse() * block);
      if (i >= centers_.size()) by_cameras->push_back(block);
    }
    return cost;
  }

 private:
  static ceres::Problem::Options Options() {
    ceres::Problem::Options options;
    options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    return options;
  }
  // The manifold's step is half a rotation vector.
  static Eigen::DiagonalMatrix<double, 6> Scale() {
    return Eigen::DiagonalMatrix<double, 6>(Vector6(2.0, 2.0, 2.0, 1.0, 1.0, 1.0));
  }
  void AddObject(size_t i, const Pose& start) {
    double* q = rotations_[i].coeffs().data();
    problem_.AddParameterBlock(q, 4, &manifold_);
    problem_.AddResidualBlock(
        new ceres::AutoDiffCostFunction<NearStart, 6, 4, 3>(
            new NearStart(Eigen::Quaterniond(start.linear()).normalized(), start * centers_[i])),
        nullptr,
        q,
        positions_[i].data());
  }
  template <int kSize>
  void AddPrior(std::span<Eigen::Matrix<double, kSize, 1>> blocks,
                const Eigen::Matrix<double, kSize, 1>& sigmas) {
    for (auto& block : blocks) {
      problem_.AddParameterBlock(block.data(), kSize);
      if (!(sigmas.minCoeff() > 0.0)) {
        problem_.SetParameterBlockConstant(block.data());
        continue;
      }
      problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<AboutZero<kSize>, kSize, kSize>(
                                    new AboutZero<kSize>(sigmas)),
                                nullptr,
                                block.data());
    }
  }
  void AddPrior(std::vector<Vector6>* blocks, const Vector6& sigmas) {
    AddPrior(std::span(*blocks), sigmas);
  }
  void AddTerm(const ViewTerm& term, const MultiViewProblem& problem) {
    VANTAGE_CHECK(term.object < centers_.size() && term.view < camera_.size(), "a term's indices");
    problem_.AddResidualBlock(
        new ceres::AutoDiffCostFunction<ViewResidual, 6, 4, 3, 6, 6, 3>(
            new ViewResidual(term, problem.T_world_camera[term.view], centers_[term.object])),
        nullptr,
        rotations_[term.object].coeffs().data(),
        positions_[term.object].data(),
        camera_[term.view].data(),
        hand_eye_.data(),
        bias_.data());
  }
  void AppendObject(size_t i, std::vector<double*>* blocks) {
    blocks->push_back(rotations_[i].coeffs().data());
    blocks->push_back(positions_[i].data());
  }
  void AppendFree(double* block, std::vector<double*>* blocks) {
    if (!problem_.IsParameterBlockConstant(block)) blocks->push_back(block);
  }

  std::vector<Eigen::Vector3d> centers_;
  std::vector<Eigen::Quaterniond> rotations_;
  std::vector<Eigen::Vector3d> positions_;  // m, of the centers, in the world.
  std::vector<Vector6> camera_;
  Vector6 hand_eye_;
  Eigen::Vector3d bias_;
  ceres::EigenQuaternionManifold manifold_;
  ceres::Problem problem_;
};

Pose MotionOf(const Vector6& motion) {
  Pose T = Pose::Identity();
  T.linear() = ExpSo3(motion.head<3>()).toRotationMatrix();
  T.translation() = motion.tail<3>();
  return T;
}

}  // namespace

Pose MultiViewState::Camera(size_t view, const Pose& T_world_camera) const {
  return T_world_camera * MotionOf(hand_eye) * MotionOf(camera[view]);
}

bool SolveMultiView(const MultiViewProblem& problem,
                    MultiViewState* state,
                    std::vector<Matrix6>* covariances) {
  CeresProblem ceres(problem, *state);
  if (!ceres.Solve()) return false;
  if (covariances != nullptr && !ceres.Covariances(covariances)) return false;
  *state = ceres.State();
  return true;
}

double MultiViewCost(const MultiViewProblem& problem,
                     const MultiViewState& state,
                     std::vector<Vector6>* by_objects,
                     std::vector<Vector6>* by_cameras) {
  return CeresProblem(problem, state).Cost(by_objects, by_cameras);
}

}  // namespace vantage
