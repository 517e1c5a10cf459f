#include "fusion/bingham/bingham_distribution.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "common/check.h"
#include "common/so3.h"
#include "fusion/bingham/bingham_normalizer.h"

namespace vantage {
namespace {

/// The z, with z_4 = 0, whose distribution has E[q_i^2] = `mean`: the maximum of the concave
/// z . mean - log F(z), by Newton's method.
/// @param mean positive, sum 1.
Eigen::Vector4d InvertMoments(const Eigen::Vector4d& mean) {
  Eigen::Vector4d z = Eigen::Vector4d::Zero();
  // Exact for narrow distributions, and 0 for the uniform one.
  z.head<3>() = 0.5 * (1.0 / mean[3] - mean.head<3>().cwiseInverse().array());
  BinghamIntegrals at = ComputeBinghamIntegrals(z);
  constexpr int kMaxIterations = 50;
  for (int i = 0; i < kMaxIterations; ++i) {
    const Eigen::Vector3d residual = (mean - at.mean).head<3>();
    if ((residual.array().abs() <= 1e-11 * mean.head<3>().array()).all()) break;
    const Eigen::Matrix3d hessian = at.covariance.topLeftCorner<3, 3>();
    // Scaled, as the variances may differ by many decades.
    const Eigen::Vector3d scale = hessian.diagonal().cwiseSqrt().cwiseInverse();
    const Eigen::Matrix3d scaled = scale.asDiagonal() * hessian * scale.asDiagonal();
    const Eigen::Vector3d step =
        scale.cwiseProduct(scaled.ldlt().solve(scale.cwiseProduct(residual)));
    // No component may lose more than half of itself: the maximum is far from flat beyond.
    double length = 1.0;
    for (Eigen::Index k = 0; k < 3; ++k) {
      length = std::min(length, (0.5 * std::abs(z[k]) + 10.0) / (std::abs(step[k]) + 1e-300));
    }
    const double before = z.dot(mean) - at.log_normalizer;
    bool improved = false;
    for (int halving = 0; halving < 30 && !improved; ++halving, length *= 0.5) {
      Eigen::Vector4d next = z;
      next.head<3>() += length * step;
      const BinghamIntegrals at_next = ComputeBinghamIntegrals(next);
      // Near the maximum the objective is flat to rounding; what counts there is the residual.
      improved =
          next.dot(mean) - at_next.log_normalizer >= before - 1e-13 * (1.0 + std::abs(before));
      if (improved) {
        z = next;
        at = at_next;
      }
    }
    if (!improved) break;
  }
  return z;
}

}  // namespace

BinghamDistribution::BinghamDistribution() : BinghamDistribution(Eigen::Matrix4d::Zero()) {}

BinghamDistribution::BinghamDistribution(const Eigen::Matrix4d& a) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(a);
  const double largest = solver.eigenvalues()[3];
  matrix_ = a - largest * Eigen::Matrix4d::Identity();
  z_ = solver.eigenvalues().array() - largest;
  directions_ = solver.eigenvectors();
  const BinghamIntegrals integrals = ComputeBinghamIntegrals(z_);
  log_normalizer_ = integrals.log_normalizer;
  scatter_ = directions_ * integrals.mean.asDiagonal() * directions_.transpose();
}

BinghamDistribution BinghamDistribution::Isotropic(const Eigen::Quaterniond& mean, double sigma) {
  VANTAGE_CHECK(sigma > 0.0, "sigma of a Bingham distribution");
  const Eigen::Vector4d q = mean.normalized().coeffs();
  return BinghamDistribution((2.0 / (sigma * sigma)) *
                             (q * q.transpose() - Eigen::Matrix4d::Identity()));
}

BinghamDistribution BinghamDistribution::Fit(const Eigen::Matrix4d& scatter) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(scatter);
  Eigen::Vector4d mean = solver.eigenvalues().cwiseMax(0.5 / kMaxFitConcentration);
  mean /= mean.sum();
  const Eigen::Vector4d z = InvertMoments(mean);
  return BinghamDistribution(solver.eigenvectors() * z.asDiagonal() *
                             solver.eigenvectors().transpose());
}

Eigen::Quaterniond BinghamDistribution::Mode() const {
  return Canonical(Eigen::Quaterniond(Eigen::Vector4d(directions_.col(3))).normalized());
}

double BinghamDistribution::LogDensity(const Eigen::Quaterniond& q) const {
  // Not q^T A q, which would lose digits near the mode of a narrow distribution.
  const Eigen::Vector4d along = directions_.transpose() * q.coeffs();
  return z_.dot(along.cwiseAbs2()) - log_normalizer_;
}

std::vector<Eigen::Quaterniond> BinghamDistribution::Sample(int count, Rng& rng) const {
  // The best envelope's b: the root of sum 1 / (b - 2 z_i) = 1, between 1 (from z_4 = 0) and 4.
  double low = 1.0;
  double high = 4.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (1.0 / (middle - 2.0 * z_.array())).sum() > 1.0 ? low = middle : high = middle;
  }
  const double b = 0.5 * (low + high);
  const Eigen::Vector4d deviation = (1.0 - 2.0 / b * z_.array()).sqrt().inverse();
  std::vector<Eigen::Quaterniond> samples;
  samples.reserve(static_cast<size_t>(count));
  while (samples.size() < static_cast<size_t>(count)) {
    Eigen::Vector4d x;
    for (Eigen::Index k = 0; k < 4; ++k) x[k] = deviation[k] * rng.Normal();
    x.normalize();
    const double u = -z_.dot(x.cwiseAbs2());
    const double ratio = (1.0 + 2.0 * u / b) * b / 4.0;
    if (rng.Uniform() < std::exp(-u + 0.5 * (4.0 - b)) * ratio * ratio) {
      samples.emplace_back(Eigen::Vector4d(directions_ * x));
    }
  }
  return samples;
}

BinghamProduct Multiply(const BinghamDistribution& a, const BinghamDistribution& b) {
  if (a.is_uniform()) return {b, -a.log_normalizer()};
  if (b.is_uniform()) return {a, -b.log_normalizer()};
  const Eigen::Matrix4d sum = a.matrix() + b.matrix();
  BinghamProduct product{BinghamDistribution(sum), 0.0};
  // The constructor took this multiple of the identity from the matrix.
  const double shift = (sum - product.distribution.matrix()).trace() / 4.0;
  product.log_weight =
      shift + product.distribution.log_normalizer() - a.log_normalizer() - b.log_normalizer();
  return product;
}

}  // namespace vantage
