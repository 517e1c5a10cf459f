#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "common/rng.h"

namespace vantage {

/// The Bingham distribution over orientations (Bingham 1974; Glover, Bradski and Rusu 2011): a
/// density over unit quaternions, with respect to the area of S^3, that is the same for q and -q:
/// p(q) = exp(q^T A q) / F = exp(sum z_i (m_i . q)^2) / F(z), z_1 <= z_2 <= z_3 <= z_4 = 0.
/// Quaternions are vectors x, y, z, w.
class BinghamDistribution {
 public:
  /// The uniform distribution.
  BinghamDistribution();
  /// @param a symmetric, finite. Only its differences from a multiple of the identity matter.
  explicit BinghamDistribution(const Eigen::Matrix4d& a);
  /// Rotation errors about a mean orientation, alike in all directions. The density is
  /// exp(z sin^2(angle / 2)), so that near 0 the error has the standard deviation `sigma` about
  /// each axis with z = -2 / sigma^2.
  /// @param sigma rad, > 0.
  static BinghamDistribution Isotropic(const Eigen::Quaterniond& mean, double sigma);
  /// The distribution of maximum likelihood for samples of this scatter, sum w q q^T with weights
  /// of sum 1; it has the same scatter. Scatters of less than 1 / (2 kMaxFitConcentration) in a
  /// direction, such as 0 of samples that are all alike, count as that.
  static BinghamDistribution Fit(const Eigen::Matrix4d& scatter);
  static constexpr double kMaxFitConcentration = 1e10;  ///< of -z; sigma = 1.4e-5 rad

  /// A, with 0 as its largest eigenvalue.
  [[nodiscard]] const Eigen::Matrix4d& matrix() const { return matrix_; }
  [[nodiscard]] const Eigen::Vector4d& z() const { return z_; }
  /// m_i in columns, orthonormal.
  [[nodiscard]] const Eigen::Matrix4d& directions() const { return directions_; }
  [[nodiscard]] double log_normalizer() const { return log_normalizer_; }
  /// E[q q^T].
  [[nodiscard]] const Eigen::Matrix4d& scatter() const { return scatter_; }
  [[nodiscard]] bool is_uniform() const { return z_[0] == 0.0; }

  /// The orientation of highest density, canonical; any one of them where there are several.
  [[nodiscard]] Eigen::Quaterniond Mode() const;
  /// log p(q) per unit area of S^3.
  [[nodiscard]] double LogDensity(const Eigen::Quaterniond& q) const;
  /// Exact, by rejection from the angular central Gaussian envelope (Kent, Ganeiber and Mardia
  /// 2013). The sign of a sample is random.
  [[nodiscard]] std::vector<Eigen::Quaterniond> Sample(int count, Rng& rng) const;

 private:
  Eigen::Matrix4d matrix_;
  Eigen::Vector4d z_;
  Eigen::Matrix4d directions_;
  Eigen::Matrix4d scatter_;
  double log_normalizer_;
};

/// a(q) b(q) = exp(log_weight) * distribution(q).
struct BinghamProduct {
  BinghamDistribution distribution;
  double log_weight = 0.0;
};
BinghamProduct Multiply(const BinghamDistribution& a, const BinghamDistribution& b);

}  // namespace vantage
