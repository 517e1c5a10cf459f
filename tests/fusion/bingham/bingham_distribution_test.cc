#include "fusion/bingham/bingham_distribution.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "common/so3.h"

namespace vantage {
namespace {

/// Symmetric, with eigenvalues from 0 down to about -spread.
Eigen::Matrix4d RandomMatrix(double spread, Rng& rng) {
  Eigen::Matrix4d a = Eigen::Matrix4d::Zero();
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector4d q = rng.Rotation().coeffs();
    a -= rng.Uniform(0.0, spread) * q * q.transpose();
  }
  return a;
}

Eigen::Matrix4d ScatterOf(const std::vector<Eigen::Quaterniond>& samples) {
  Eigen::Matrix4d scatter = Eigen::Matrix4d::Zero();
  for (const Eigen::Quaterniond& q : samples) scatter += q.coeffs() * q.coeffs().transpose();
  return scatter / static_cast<double>(samples.size());
}

TEST(BinghamDistribution, DensityIsThatOfTheMatrixForBothSigns) {
  Rng rng(1);
  for (int i = 0; i < 20; ++i) {
    const BinghamDistribution bingham(RandomMatrix(100.0, rng));
    const Eigen::Quaterniond q = rng.Rotation();
    const Eigen::Quaterniond negated(-q.coeffs());
    EXPECT_NEAR(bingham.LogDensity(q),
                q.coeffs().dot(bingham.matrix() * q.coeffs()) - bingham.log_normalizer(),
                1e-11);
    EXPECT_EQ(bingham.LogDensity(q), bingham.LogDensity(negated));
    EXPECT_LE(bingham.LogDensity(q), bingham.LogDensity(bingham.Mode()));
    EXPECT_NEAR(bingham.scatter().trace(), 1.0, 1e-12);
  }
}

TEST(BinghamDistribution, DensityIntegratesToOne) {
  Rng rng(2);
  const BinghamDistribution bingham(RandomMatrix(6.0, rng));
  double sum = 0.0;
  double squared = 0.0;
  constexpr int kCount = 200'000;
  for (int i = 0; i < kCount; ++i) {
    const double ratio =
        2.0 * std::numbers::pi * std::numbers::pi * std::exp(bingham.LogDensity(rng.Rotation()));
    sum += ratio;
    squared += ratio * ratio;
  }
  const double mean = sum / kCount;
  const double error = std::sqrt((squared / kCount - mean * mean) / kCount);
  EXPECT_LT(error, 0.01);
  EXPECT_NEAR(mean, 1.0, 5.0 * error);
}

TEST(BinghamDistribution, IsotropicHasTheStandardDeviationAboutEachAxis) {
  Rng rng(3);
  const Eigen::Quaterniond mean = rng.Rotation();
  const double sigma = 4.0 * kDegree;
  const BinghamDistribution bingham = BinghamDistribution::Isotropic(mean, sigma);
  EXPECT_LT(GeodesicAngle(bingham.Mode(), mean), 1e-9);
  EXPECT_NEAR(bingham.z()[0], -2.0 / (sigma * sigma), 1e-9);
  EXPECT_NEAR(bingham.z()[2], -2.0 / (sigma * sigma), 1e-9);
  const double angle = 0.3;
  const double s = std::sin(angle / 2.0);
  EXPECT_NEAR(bingham.LogDensity(mean * ExpSo3(Eigen::Vector3d(angle, 0.0, 0.0))) -
                  bingham.LogDensity(mean),
              -2.0 / (sigma * sigma) * s * s,
              1e-9);
  constexpr int kCount = 20'000;
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  for (const Eigen::Quaterniond& q : bingham.Sample(kCount, rng)) {
    squares += LogSo3(mean.conjugate() * q).cwiseAbs2();
  }
  // Standard error of a variance: sqrt(2 / n), of a deviation half of that.
  for (Eigen::Index k = 0; k < 3; ++k) {
    EXPECT_NEAR(std::sqrt(squares[k] / kCount) / sigma, 1.0, 5.0 * 0.5 * std::sqrt(2.0 / kCount));
  }
}

TEST(BinghamDistribution, SamplesHaveTheMoments) {
  Rng rng(4);
  for (const double spread : {0.0, 1.0, 10.0, 1000.0, 1e7}) {
    SCOPED_TRACE(spread);
    const BinghamDistribution bingham(RandomMatrix(spread, rng));
    constexpr int kCount = 40'000;
    const std::vector<Eigen::Quaterniond> samples = bingham.Sample(kCount, rng);
    ASSERT_EQ(samples.size(), static_cast<size_t>(kCount));
    Eigen::Vector4d mean = Eigen::Vector4d::Zero();
    Eigen::Vector4d fourth = Eigen::Vector4d::Zero();
    int num_positive = 0;
    for (const Eigen::Quaterniond& q : samples) {
      EXPECT_NEAR(q.norm(), 1.0, 1e-12);
      const Eigen::Vector4d along = bingham.directions().transpose() * q.coeffs();
      mean += along.cwiseAbs2() / kCount;
      fourth += along.cwiseAbs2().cwiseAbs2() / kCount;
      if (along[3] > 0.0) ++num_positive;
    }
    const Eigen::Vector4d expected =
        (bingham.directions().transpose() * bingham.scatter() * bingham.directions()).diagonal();
    for (Eigen::Index k = 0; k < 4; ++k) {
      const double error = std::sqrt((fourth[k] - mean[k] * mean[k]) / kCount);
      EXPECT_NEAR(mean[k], expected[k], 5.0 * error + 1e-12) << k;
    }
    EXPECT_NEAR(num_positive, kCount / 2, 5.0 * 0.5 * std::sqrt(kCount));
  }
}

/// Chi-square over bins of equal probability, found by the density itself: of the angle from the
/// mode, by counting uniform samples weighted with the density.
TEST(BinghamDistribution, SamplesHaveTheDensity) {
  Rng rng(5);
  const BinghamDistribution bingham(RandomMatrix(8.0, rng));
  constexpr size_t kBins = 12;
  const auto bin_of = [&bingham](const Eigen::Quaterniond& q) {
    const double share = GeodesicAngle(q, bingham.Mode()) / std::numbers::pi;
    return std::min(kBins - 1, static_cast<size_t>(share * kBins));
  };
  std::vector<double> expected(kBins, 0.0);
  double total = 0.0;
  for (int i = 0; i < 1'000'000; ++i) {
    const Eigen::Quaterniond q = rng.Rotation();
    const double density = std::exp(bingham.LogDensity(q));
    expected[bin_of(q)] += density;
    total += density;
  }
  std::vector<double> observed(kBins, 0.0);
  constexpr int kCount = 20'000;
  for (const Eigen::Quaterniond& q : bingham.Sample(kCount, rng)) observed[bin_of(q)] += 1.0;
  double chi_square = 0.0;
  for (size_t i = 0; i < kBins; ++i) {
    const double mean = expected[i] / total * kCount;
    if (mean < 5.0) continue;
    chi_square += (observed[i] - mean) * (observed[i] - mean) / mean;
  }
  EXPECT_LT(chi_square, 35.0);  // Probability 2e-4 at 11 degrees of freedom.
}

TEST(BinghamDistribution, ProductIsThePointwiseProduct) {
  Rng rng(6);
  for (const double spread : {0.0, 1.0, 50.0, 1e4}) {
    for (int i = 0; i < 10; ++i) {
      const BinghamDistribution a(RandomMatrix(spread, rng));
      const BinghamDistribution b(RandomMatrix(100.0, rng));
      const BinghamProduct product = Multiply(a, b);
      for (int k = 0; k < 10; ++k) {
        const Eigen::Quaterniond q = rng.Rotation();
        EXPECT_NEAR(product.log_weight + product.distribution.LogDensity(q),
                    a.LogDensity(q) + b.LogDensity(q),
                    1e-9 * (1.0 + spread));
      }
    }
  }
}

TEST(BinghamDistribution, FitHasTheScatter) {
  Rng rng(7);
  for (const double spread : {0.0, 0.01, 1.0, 30.0, 1e3, 1e6, 1e8}) {
    for (int i = 0; i < 5; ++i) {
      SCOPED_TRACE(spread);
      const BinghamDistribution bingham(RandomMatrix(spread, rng));
      const BinghamDistribution fitted = BinghamDistribution::Fit(bingham.scatter());
      // Moments of 1 / spread are differences of entries near 1.
      const double tolerance = 1e-8 + 1e-14 * spread;
      for (Eigen::Index k = 0; k < 4; ++k) {
        EXPECT_NEAR(fitted.z()[k], bingham.z()[k], tolerance * (1.0 - bingham.z()[k])) << k;
      }
      EXPECT_LT((fitted.scatter() - bingham.scatter()).norm(), 1e-10);
    }
  }
}

TEST(BinghamDistribution, FitRecoversWhatSamplesWereDrawnFrom) {
  Rng rng(8);
  for (const double spread : {5.0, 200.0, 1e5}) {
    const BinghamDistribution bingham(RandomMatrix(spread, rng));
    const BinghamDistribution fitted =
        BinghamDistribution::Fit(ScatterOf(bingham.Sample(100'000, rng)));
    for (Eigen::Index k = 0; k < 3; ++k) {
      EXPECT_NEAR(fitted.z()[k], bingham.z()[k], 0.05 * -bingham.z()[k] + 0.1) << k;
    }
  }
}

TEST(BinghamDistribution, FitOfIdenticalOrNearlyFlatSamplesIsBounded) {
  Rng rng(9);
  const Eigen::Quaterniond q = rng.Rotation();
  const BinghamDistribution point = BinghamDistribution::Fit(q.coeffs() * q.coeffs().transpose());
  EXPECT_LT(GeodesicAngle(point.Mode(), q), 1e-9);
  EXPECT_TRUE(std::isfinite(point.LogDensity(q)));
  for (Eigen::Index k = 0; k < 3; ++k) {
    EXPECT_NEAR(point.z()[k] / -BinghamDistribution::kMaxFitConcentration, 1.0, 1e-3);
  }
  // All about one axis: a great circle of S^3.
  Eigen::Matrix4d circle = Eigen::Matrix4d::Zero();
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector4d on_circle =
        (q * ExpSo3(Eigen::Vector3d(0.0, 0.0, 2.0 * std::numbers::pi * i / 100.0))).coeffs();
    circle += 0.01 * on_circle * on_circle.transpose();
  }
  const BinghamDistribution ring = BinghamDistribution::Fit(circle);
  EXPECT_LT(ring.z()[1], -1e9);
  EXPECT_NEAR(ring.z()[2], 0.0, 1e-4);
}

TEST(BinghamDistribution, AMillionEqualFactorsStayExact) {
  Rng rng(10);
  const Eigen::Quaterniond q = rng.Rotation();
  const BinghamDistribution factor = BinghamDistribution::Isotropic(q, 4.0 * kDegree);
  BinghamDistribution product = factor;
  constexpr int kCount = 1'000'000;
  for (int i = 1; i < kCount; ++i) product = Multiply(product, factor).distribution;
  EXPECT_NEAR(product.z()[0] / (kCount * factor.z()[0]), 1.0, 1e-8);
  EXPECT_NEAR(product.z()[2] / (kCount * factor.z()[2]), 1.0, 1e-8);
  EXPECT_LT(GeodesicAngle(product.Mode(), q), 1e-8);
}

}  // namespace
}  // namespace vantage
