#include "perception/calibration/residual_statistics.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>

namespace vantage {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

/// Chance that a set of views without outliers loses any.
constexpr double kFalseAlarms = 0.01;
/// Chance that rotations and translations of equal scale are told apart.
constexpr double kFalseSplits = 0.01;
/// What is known less well than this counts as not known: 10 m, 1000 deg, 10 s.
constexpr double kLeastInformation = 1e-8;
constexpr double kLeastRelativeInformation = 1e-15;
/// Residuals without any noise still have a scale.
constexpr double kLeastSum = 1e-18;

double FisherQuantile(double freedom_1, double freedom_2, double probability) {
  return boost::math::quantile(boost::math::fisher_f_distribution<double>(freedom_1, freedom_2),
                               probability);
}

/// 0.1 deg, 1 mm, a thousandth of scale, 1 ms.
Eigen::VectorXd Units(Eigen::Index size) {
  Eigen::VectorXd units = Eigen::VectorXd::Constant(size, 1e-3);
  units.segment<3>(0).setConstant(0.1 * kDegree);
  units.segment<3>(6).setConstant(0.1 * kDegree);
  return units;
}

Eigen::Index RowOf(size_t view) { return 6 * static_cast<Eigen::Index>(view); }

/// Scales by sums of squares of residuals that are whitened by `present` ones: the same for
/// rotations and translations unless they differ by more than chance (Fisher's variance ratio).
ResidualScales NewScales(const ResidualScales& present,
                         double rotation_sum,
                         double translation_sum,
                         const ResidualStatistics& statistics) {
  rotation_sum *= present.rotation * present.rotation;
  translation_sum *= present.translation * present.translation;
  const double freedom = statistics.rotation_freedom + statistics.translation_freedom;
  if (freedom < 0.5) return present;
  if (std::min(statistics.rotation_freedom, statistics.translation_freedom) >= 1.0) {
    const double rotation = rotation_sum / statistics.rotation_freedom;
    const double translation = translation_sum / statistics.translation_freedom;
    const bool is_rotation_larger = rotation > translation;
    const double limit = is_rotation_larger ? FisherQuantile(statistics.rotation_freedom,
                                                             statistics.translation_freedom,
                                                             1.0 - 0.5 * kFalseSplits)
                                            : FisherQuantile(statistics.translation_freedom,
                                                             statistics.rotation_freedom,
                                                             1.0 - 0.5 * kFalseSplits);
    if (std::max(rotation, translation) > limit * std::min(rotation, translation)) {
      return {std::sqrt(rotation), std::sqrt(translation)};
    }
  }
  const double common = std::sqrt((rotation_sum + translation_sum) / freedom);
  return {common, common};
}

/// Information and covariance of the views used, and of every view what the estimate takes from its
/// residual: the hat matrix's blocks on the diagonal.
std::vector<Matrix6d> SetInformation(const AdjustmentLinearization& linearization,
                                     const std::vector<bool>& uses,
                                     ResidualStatistics* statistics) {
  const Eigen::MatrixXd& jacobian = linearization.jacobian;
  statistics->information = Eigen::MatrixXd::Zero(jacobian.cols(), jacobian.cols());
  for (size_t i = 0; i < uses.size(); ++i) {
    if (!uses[i]) continue;
    const auto rows = jacobian.middleRows<6>(RowOf(i));
    statistics->information.noalias() += rows.transpose() * rows;
  }
  statistics->covariance = CovarianceOf(statistics->information);
  std::vector<Matrix6d> hat;
  for (size_t i = 0; i < uses.size(); ++i) {
    const auto rows = jacobian.middleRows<6>(RowOf(i));
    hat.emplace_back(rows * statistics->covariance * rows.transpose());
  }
  return hat;
}

/// By studentized residuals, of the views used by what the others say (Cook, Weisberg, "Residuals
/// and Influence in Regression", 1982, section 2.2).
/// @param by_scale from whitened residuals to those of the new scales.
std::vector<bool> FindOutliers(const AdjustmentLinearization& linearization,
                               const std::vector<bool>& uses,
                               const std::vector<Matrix6d>& hat,
                               const Vector6d& by_scale,
                               double freedom) {
  std::vector<bool> is_outlier(uses.size(), false);
  if (freedom < 6.5) return is_outlier;  // Too few to tell.
  const double chance = kFalseAlarms / static_cast<double>(uses.size());
  const double limit_inside = FisherQuantile(6.0, freedom - 6.0, 1.0 - chance);
  const double limit_outside = FisherQuantile(6.0, freedom, 1.0 - chance);
  for (size_t i = 0; i < uses.size(); ++i) {
    const Vector6d residual = by_scale.cwiseProduct(linearization.residuals.segment<6>(RowOf(i)));
    if (uses[i]) {
      const Matrix6d left = Matrix6d::Identity() - hat[i];
      // A view that takes almost all that there is of a direction can't be told from the others.
      if (left.determinant() < 1e-6) continue;
      const double squared = residual.dot(left.ldlt().solve(residual));
      const double rest = std::max(freedom - squared, 1e-9) / (freedom - 6.0);
      is_outlier[i] = squared / 6.0 > limit_inside * rest;
    } else {
      const Matrix6d spread = Matrix6d::Identity() + hat[i];
      is_outlier[i] = residual.dot(spread.ldlt().solve(residual)) / 6.0 > limit_outside;
    }
  }
  return is_outlier;
}

}  // namespace

Eigen::MatrixXd CovarianceOf(const Eigen::MatrixXd& information) {
  const Eigen::VectorXd units = Units(information.rows());
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(units.asDiagonal() * information *
                                                             units.asDiagonal());
  const double least =
      std::max(kLeastInformation, kLeastRelativeInformation * eigen.eigenvalues().maxCoeff());
  const Eigen::MatrixXd vectors = units.asDiagonal() * eigen.eigenvectors();
  return vectors * eigen.eigenvalues().cwiseMax(least).cwiseInverse().asDiagonal() *
         vectors.transpose();
}

ResidualStatistics EvaluateResiduals(const AdjustmentLinearization& linearization,
                                     const std::vector<bool>& uses,
                                     const ResidualScales& present) {
  ResidualStatistics statistics;
  const std::vector<Matrix6d> hat = SetInformation(linearization, uses, &statistics);
  double rotation_sum = kLeastSum;
  double translation_sum = kLeastSum;
  for (size_t i = 0; i < uses.size(); ++i) {
    if (!uses[i]) continue;
    const Vector6d residual = linearization.residuals.segment<6>(RowOf(i));
    rotation_sum += residual.head<3>().squaredNorm();
    translation_sum += residual.tail<3>().squaredNorm();
    statistics.rotation_freedom += 3.0 - hat[i].topLeftCorner<3, 3>().trace();
    statistics.translation_freedom += 3.0 - hat[i].bottomRightCorner<3, 3>().trace();
  }
  statistics.scales = NewScales(present, rotation_sum, translation_sum, statistics);
  Vector6d by_scale;
  by_scale << Eigen::Vector3d::Constant(present.rotation / statistics.scales.rotation),
      Eigen::Vector3d::Constant(present.translation / statistics.scales.translation);
  statistics.is_outlier =
      FindOutliers(linearization,
                   uses,
                   hat,
                   by_scale,
                   statistics.rotation_freedom + statistics.translation_freedom);
  return statistics;
}

Eigen::VectorXd StepWithout(const AdjustmentLinearization& linearization,
                            const ResidualStatistics& statistics,
                            size_t view) {
  const auto rows = linearization.jacobian.middleRows<6>(RowOf(view));
  const Vector6d residual = linearization.residuals.segment<6>(RowOf(view));
  const Eigen::MatrixXd information = statistics.information - rows.transpose() * rows;
  return CovarianceOf(information) * (rows.transpose() * residual);
}

}  // namespace vantage
