#include "fusion/quaternion_mean.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>

#include "common/check.h"
#include "common/so3.h"

namespace vantage {

Eigen::Quaterniond WeightedMean(std::span<const WeightedOrientation> orientations) {
  VANTAGE_CHECK(!orientations.empty(), "the mean of no orientations");
  const Eigen::Vector4d side = orientations.front().q.coeffs();
  // Quaternions at more than 45 degrees from the first one differ from it by more than 90.
  constexpr double kDoubt = std::numbers::sqrt2 / 2.0;
  bool in_doubt = false;
  Eigen::Vector4d sum = Eigen::Vector4d::Zero();
  for (const WeightedOrientation& orientation : orientations) {
    const double dot = orientation.q.coeffs().dot(side);
    in_doubt = in_doubt || std::abs(dot) < kDoubt;
    sum += (dot < 0.0 ? -orientation.weight : orientation.weight) * orientation.q.coeffs();
  }
  if (!in_doubt) return Canonical(Eigen::Quaterniond(sum).normalized());

  Eigen::Matrix4d scatter = Eigen::Matrix4d::Zero();
  for (const WeightedOrientation& orientation : orientations) {
    scatter += orientation.weight * orientation.q.coeffs() * orientation.q.coeffs().transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(scatter);
  return Canonical(Eigen::Quaterniond(Eigen::Vector4d(solver.eigenvectors().col(3))).normalized());
}

}  // namespace vantage
