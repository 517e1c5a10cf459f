#pragma once

#include <Eigen/Core>

namespace vantage {

/// Integrals of exp(sum z_i q_i^2) over the unit sphere S^3 (area 2 pi^2).
struct BinghamIntegrals {
  double log_normalizer = 0.0;  ///< log F(z) of the integral itself
  /// E[q_i^2] under the normalized density: the gradient of log F.
  Eigen::Vector4d mean = Eigen::Vector4d::Constant(0.25);
  /// Cov[q_i^2, q_j^2]: the Hessian of log F.
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
};

/// The normalizing constant of the Bingham distribution (Bingham 1974) and its derivatives. Adding
/// a constant to all z adds it to log F; order does not matter.
///
/// With z sorted and the largest one 0: where z_3 <= -60, by Gaussian moments of the expansion of
/// the surface element; else by a one-dimensional quadrature, as S^3 is made of pairs of circles.
/// Relative error of F below 1e-10 while the smallest z is at least -1e5 and below 1e-8 to -1e10,
/// of the means ten times that; the worst where z_1 << z_2 and z_3 > -60.
/// @param z finite.
BinghamIntegrals ComputeBinghamIntegrals(const Eigen::Vector4d& z);

}  // namespace vantage
