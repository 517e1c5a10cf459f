#include "perception/refinement/pose_covariance.h"

#include <Eigen/Eigenvalues>
#include <algorithm>

namespace vantage {

Matrix6 PoseCovariance(const MotionEquations& equations,
                       double pixels_per_pair,
                       double lever,
                       double depth,
                       const RefinementParameters& parameters) {
  constexpr double kSlant = 2.5 * kDegree;  // Standard deviation of a mesh's normals.
  // Rotations as the arc that they move a point at the lever's end: all directions are lengths.
  Vector6 scale = Vector6::Ones();
  scale.head<3>() /= lever;
  const Matrix6 scaled = scale.asDiagonal() * equations.information * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix6> directions(scaled);
  const double independent = std::min(pixels_per_pair / parameters.correlated_px, 1.0);
  const double slants = kSlant * kSlant * equations.weight;
  Vector6 variances;
  for (int i = 0; i < 6; ++i) {
    const double information = std::max(directions.eigenvalues()[i] - slants, 0.0);
    variances[i] = 1.0 / (independent * information + 1.0 / (lever * lever));
  }
  const Matrix6& axes = directions.eigenvectors();
  Matrix6 covariance =
      scale.asDiagonal() * axes * variances.asDiagonal() * axes.transpose() * scale.asDiagonal();
  const double shift = parameters.bias_at_1m * depth * depth;
  covariance.diagonal().head<2>().array() += parameters.bias_tilt * parameters.bias_tilt;
  covariance(5, 5) += shift * shift;
  // Symmetric to the last bit, which messages ask for and rounding does not leave.
  return 0.5 * (covariance + covariance.transpose());
}

}  // namespace vantage
