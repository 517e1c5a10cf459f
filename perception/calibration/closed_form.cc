#include "perception/calibration/closed_form.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace vantage {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

/// Rotations that spread less than this leave the translation along their axis open.
constexpr double kLeastSpread = 2e-3;  // rad
/// Two views whose rotations differ by more have no reliable logarithm.
constexpr double kLargestAngle = 3.0;  // rad

/// The rotation U D V^T that comes closest to a matrix, or turns b's best into a's for the matrix
/// of sums of a b^T (Umeyama 1991).
Matrix3d NearestRotation(const Matrix3d& matrix) {
  const Eigen::JacobiSVD<Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d flip = Matrix3d::Identity();
  flip(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  return svd.matrixU() * flip * svd.matrixV().transpose();
}

bool IsFinite(const HandEyeTransforms& solution) {
  return solution.T_x.matrix().allFinite() && solution.T_y.matrix().allFinite();
}

/// Translations of X and Y for the rotation of X: R_A t_X - t_Y = -(t_A + R_A R_X t_B), with t_Y
/// eliminated; the rotation of Y is the mean of R_A R_X R_B.
std::optional<HandEyeTransforms> CompleteFromRotation(std::span<const HandEyeEquation> equations,
                                                      const Matrix3d& R_x) {
  const double count = static_cast<double>(equations.size());
  Matrix3d mean_R_a = Matrix3d::Zero();
  Matrix3d sum_R_y = Matrix3d::Zero();
  Vector3d mean_c = Vector3d::Zero();
  const auto constant = [&R_x](const HandEyeEquation& equation) -> Vector3d {
    return equation.A * (R_x * equation.B.translation());
  };
  for (const HandEyeEquation& equation : equations) {
    mean_R_a += equation.A.linear() / count;
    mean_c += constant(equation) / count;
    sum_R_y += equation.A.linear() * R_x * equation.B.linear();
  }
  Matrix3d normal = Matrix3d::Zero();
  Vector3d right = Vector3d::Zero();
  for (const HandEyeEquation& equation : equations) {
    const Matrix3d centered = equation.A.linear() - mean_R_a;
    normal += centered.transpose() * centered;
    right -= centered.transpose() * (constant(equation) - mean_c);
  }
  if (!normal.allFinite() || !right.allFinite()) return std::nullopt;
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(normal);
  HandEyeTransforms solution;
  solution.T_x.linear() = R_x;
  for (int i = 0; i < 3; ++i) {
    if (eigen.eigenvalues()[i] < count * kLeastSpread * kLeastSpread) continue;
    const Vector3d direction = eigen.eigenvectors().col(i);
    solution.T_x.translation() += direction * (direction.dot(right) / eigen.eigenvalues()[i]);
  }
  solution.T_y.linear() = NearestRotation(sum_R_y);
  solution.T_y.translation() = mean_R_a * solution.T_x.translation() + mean_c;
  if (!IsFinite(solution)) return std::nullopt;
  return solution;
}

/// The rotation about `axis` to put before R_x that the translations ask for: linear in its cosine
/// and sine and in t_X, t_Y.
Matrix3d RotationAboutAxis(std::span<const HandEyeEquation> equations,
                           const Vector3d& axis,
                           const Matrix3d& R_x) {
  const auto rows = static_cast<Eigen::Index>(3 * equations.size());
  Eigen::MatrixXd matrix(rows, 8);
  Eigen::VectorXd right(rows);
  for (size_t i = 0; i < equations.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(3 * i);
    const Matrix3d R_a = equations[i].A.linear();
    const Vector3d b = R_x * equations[i].B.translation();
    const Vector3d along = axis * axis.dot(b);
    matrix.block<3, 1>(row, 0) = R_a * (b - along);
    matrix.block<3, 1>(row, 1) = R_a * axis.cross(b);
    matrix.block<3, 3>(row, 2) = R_a;
    matrix.block<3, 3>(row, 5) = -Matrix3d::Identity();
    right.segment<3>(row) = -(equations[i].A.translation() + R_a * along);
  }
  const Eigen::VectorXd solution =
      Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd>(matrix).solve(right);
  const double angle = std::atan2(solution[1], solution[0]);
  return std::isfinite(angle) ? ExpSo3(angle * axis).toRotationMatrix() : Matrix3d::Identity();
}

/// A relative motion: A_j^-1 A_i X = X B_j B_i^-1.
struct Motion {
  Quaterniond q_a;
  Quaterniond q_b;
  Vector3d t_a;
  Vector3d t_b;
};

/// Calls `use` with every relative motion that turns by less than kLargestAngle.
template <class Use>
void ForEachMotion(std::span<const HandEyeEquation> equations, const Use& use) {
  std::vector<Quaterniond> q_a;
  std::vector<Quaterniond> q_b;
  for (const HandEyeEquation& equation : equations) {
    q_a.emplace_back(equation.A.linear());
    q_b.emplace_back(equation.B.linear());
  }
  const double least_w = std::cos(0.5 * kLargestAngle);
  for (size_t i = 0; i < equations.size(); ++i) {
    for (size_t j = i + 1; j < equations.size(); ++j) {
      Motion motion;
      motion.q_a = Canonical(q_a[j].conjugate() * q_a[i]);
      motion.q_b = Canonical(q_b[j] * q_b[i].conjugate());
      if (motion.q_a.w() < least_w || motion.q_b.w() < least_w) continue;
      motion.t_a = equations[j].A.linear().transpose() *
                   (equations[i].A.translation() - equations[j].A.translation());
      motion.t_b = equations[j].B.translation() - motion.q_b * equations[i].B.translation();
      use(motion);
    }
  }
}

Quaterniond PureQuaternion(const Vector3d& v) { return Quaterniond(0.0, v.x(), v.y(), v.z()); }

/// Real and dual part of a rigid motion (Daniilidis, Eq. 6), coefficients (x, y, z, w).
struct DualQuaternion {
  Eigen::Vector4d real;
  Eigen::Vector4d dual;
};

DualQuaternion MakeDualQuaternion(const Quaterniond& q, const Vector3d& t) {
  return {q.coeffs(), 0.5 * (PureQuaternion(t) * q).coeffs()};
}

/// [v]x.
Matrix3d Cross(const Vector3d& v) {
  Matrix3d matrix;
  matrix << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return matrix;
}

}  // namespace

Pose EquationOfHand(HandEyeSetup setup, const Pose& T_base_hand) {
  return setup == HandEyeSetup::kEyeInHand ? T_base_hand : T_base_hand.inverse();
}

std::optional<HandEyeTransforms> SolvePark(std::span<const HandEyeEquation> equations) {
  if (equations.size() < 3) return std::nullopt;
  Matrix3d rotations = Matrix3d::Zero();
  Matrix3d translations = Matrix3d::Zero();
  double count = 0.0;
  ForEachMotion(equations, [&](const Motion& motion) {
    rotations += LogSo3(motion.q_a) * LogSo3(motion.q_b).transpose();
    translations += motion.t_a * motion.t_b.transpose();
    count += 1.0;
  });
  if (count == 0.0 || !rotations.allFinite() || !translations.allFinite()) return std::nullopt;
  const Eigen::JacobiSVD<Matrix3d> svd(rotations, Eigen::ComputeFullU);
  const double least = count * kLeastSpread * kLeastSpread;
  if (svd.singularValues()[0] < least) {
    return CompleteFromRotation(equations, NearestRotation(translations));
  }
  Matrix3d R_x = NearestRotation(rotations);
  if (svd.singularValues()[1] < least) {
    R_x = RotationAboutAxis(equations, svd.matrixU().col(0), R_x) * R_x;
  }
  return CompleteFromRotation(equations, R_x);
}

std::optional<HandEyeTransforms> SolveDaniilidis(std::span<const HandEyeEquation> equations) {
  if (equations.size() < 3) return std::nullopt;
  Eigen::Matrix<double, 8, 8> normal = Eigen::Matrix<double, 8, 8>::Zero();
  ForEachMotion(equations, [&normal](const Motion& motion) {
    const DualQuaternion a = MakeDualQuaternion(motion.q_a, motion.t_a);
    const DualQuaternion b = MakeDualQuaternion(motion.q_b, motion.t_b);
    // Eq. 31, with columns (x, y, z, w) of the real and of the dual part of X.
    Eigen::Matrix<double, 6, 8> rows = Eigen::Matrix<double, 6, 8>::Zero();
    const Matrix3d turn = Cross(a.real.head<3>() + b.real.head<3>());
    rows.block<3, 3>(0, 0) = turn;
    rows.block<3, 1>(0, 3) = a.real.head<3>() - b.real.head<3>();
    rows.block<3, 3>(3, 0) = Cross(a.dual.head<3>() + b.dual.head<3>());
    rows.block<3, 1>(3, 3) = a.dual.head<3>() - b.dual.head<3>();
    rows.block<3, 3>(3, 4) = turn;
    rows.block<3, 1>(3, 7) = rows.block<3, 1>(0, 3);
    normal += rows.transpose() * rows;
  });
  if (!normal.allFinite()) return std::nullopt;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 8, 8>> eigen(normal);
  const Eigen::Vector4d u1 = eigen.eigenvectors().col(0).head<4>();
  const Eigen::Vector4d v1 = eigen.eigenvectors().col(0).tail<4>();
  const Eigen::Vector4d u2 = eigen.eigenvectors().col(1).head<4>();
  const Eigen::Vector4d v2 = eigen.eigenvectors().col(1).tail<4>();
  // X = l1 (u1, v1) + l2 (u2, v2) with real . dual = 0 (Eq. 35), solved for l1 = c, l2 = s on the
  // circle; of the two solutions that with the longer real part (Eq. 34).
  const double a = u1.dot(v1);
  const double b = u1.dot(v2) + u2.dot(v1);
  const double c = u2.dot(v2);
  const double phase = std::atan2(b, a - c);
  const double offset = std::acos(std::clamp(-(a + c) / std::hypot(b, a - c), -1.0, 1.0));
  Eigen::Matrix<double, 8, 1> best = Eigen::Matrix<double, 8, 1>::Zero();
  for (const double angle : {0.5 * (phase + offset), 0.5 * (phase - offset)}) {
    const Eigen::Matrix<double, 8, 1> x = std::cos(angle) * eigen.eigenvectors().col(0) +
                                          std::sin(angle) * eigen.eigenvectors().col(1);
    if (x.head<4>().norm() > best.head<4>().norm()) best = x;
  }
  if (!best.allFinite() || best.head<4>().norm() < 1e-9) return std::nullopt;
  return CompleteFromRotation(
      equations, Quaterniond(Eigen::Vector4d(best.head<4>().normalized())).toRotationMatrix());
}

std::optional<HandEyeTransforms> SolveShah(std::span<const HandEyeEquation> equations) {
  if (equations.size() < 3) return std::nullopt;
  // Columns stacked: vec(R_A R_X R_B) = (R_B^T kron R_A) vec(R_X), and the sum of these matrices
  // takes vec(R_X) to n vec(R_Y).
  using Matrix9d = Eigen::Matrix<double, 9, 9>;
  Matrix9d sum = Matrix9d::Zero();
  for (const HandEyeEquation& equation : equations) {
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) {
        sum.block<3, 3>(3 * row, 3 * column) +=
            equation.B.linear()(column, row) * equation.A.linear();
      }
    }
  }
  if (!sum.allFinite()) return std::nullopt;
  const Eigen::SelfAdjointEigenSolver<Matrix9d> eigen(sum.transpose() * sum);
  const Eigen::Matrix<double, 9, 1> leading = eigen.eigenvectors().col(8);
  Matrix3d R_x = Eigen::Map<const Matrix3d>(leading.data());
  if (R_x.determinant() < 0.0) R_x = -R_x;
  return CompleteFromRotation(equations, NearestRotation(R_x));
}

std::span<const ClosedForm> ClosedForms() {
  static constexpr std::array<ClosedForm, 3> kAll = {ClosedForm{"Park and Martin", SolvePark},
                                                     ClosedForm{"Daniilidis", SolveDaniilidis},
                                                     ClosedForm{"Shah", SolveShah}};
  return kAll;
}

}  // namespace vantage
