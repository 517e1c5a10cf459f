#include "fusion/bingham/bingham_normalizer.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace vantage {
namespace {

constexpr double kPi = std::numbers::pi;

struct Rule {
  std::vector<double> points;
  std::vector<double> weights;
};

/// Gauss-Legendre on [lo, hi], by Newton's method on the Legendre polynomial.
Rule GaussLegendre(int count, double lo, double hi) {
  Rule rule;
  for (int i = 0; i < count; ++i) {
    double x = std::cos(kPi * (i + 0.75) / (count + 0.5));
    double slope = 1.0;
    for (int step = 0; step < 50; ++step) {
      double p = 1.0;
      double before = 0.0;
      for (int n = 1; n <= count; ++n) {
        const double next = ((2.0 * n - 1.0) * x * p - (n - 1.0) * before) / n;
        before = p;
        p = next;
      }
      slope = count * (x * p - before) / (x * x - 1.0);
      x -= p / slope;
    }
    rule.points.push_back(0.5 * (lo + hi) + 0.5 * (hi - lo) * x);
    rule.weights.push_back((hi - lo) / ((1.0 - x * x) * slope * slope));
  }
  return rule;
}

struct BruteForce {
  double normalizer = 0.0;
  Eigen::Vector4d mean = Eigen::Vector4d::Zero();
  Eigen::Matrix4d second = Eigen::Matrix4d::Zero();
};

/// Over one orthant of S^3 in hyperspherical coordinates, times 16.
BruteForce Integrate(const Eigen::Vector4d& z) {
  const Rule rule = GaussLegendre(48, 0.0, 0.5 * kPi);
  BruteForce result;
  for (size_t i = 0; i < rule.points.size(); ++i) {
    const double a = rule.points[i];
    for (size_t j = 0; j < rule.points.size(); ++j) {
      const double b = rule.points[j];
      for (size_t k = 0; k < rule.points.size(); ++k) {
        const double c = rule.points[k];
        const Eigen::Vector4d q(std::cos(a),
                                std::sin(a) * std::cos(b),
                                std::sin(a) * std::sin(b) * std::cos(c),
                                std::sin(a) * std::sin(b) * std::sin(c));
        const Eigen::Vector4d squares = q.cwiseAbs2();
        const double value = 16.0 * rule.weights[i] * rule.weights[j] * rule.weights[k] *
                             std::sin(a) * std::sin(a) * std::sin(b) * std::exp(z.dot(squares));
        result.normalizer += value;
        result.mean += value * squares;
        result.second += value * squares * squares.transpose();
      }
    }
  }
  result.mean /= result.normalizer;
  result.second /= result.normalizer;
  return result;
}

TEST(BinghamNormalizer, UniformHasTheAreaOfTheSphere) {
  const BinghamIntegrals uniform = ComputeBinghamIntegrals(Eigen::Vector4d::Zero());
  EXPECT_NEAR(uniform.log_normalizer, std::log(2.0 * kPi * kPi), 1e-14);
  EXPECT_LT((uniform.mean - Eigen::Vector4d::Constant(0.25)).norm(), 1e-14);
  EXPECT_NEAR(uniform.covariance(0, 0), 1.0 / 8.0 - 1.0 / 16.0, 1e-14);   // E[q^4] = 3 / 24
  EXPECT_NEAR(uniform.covariance(1, 2), 1.0 / 24.0 - 1.0 / 16.0, 1e-14);  // E = 1 / 24
}

TEST(BinghamNormalizer, EqualsTheIntegralOverTheSphere) {
  const std::vector<Eigen::Vector4d> cases = {{-1.0, -0.5, -0.1, 0.0},
                                              {-10.0, -3.0, -1.0, 0.0},
                                              {-40.0, -40.0, -40.0, 0.0},
                                              {-50.0, -20.0, 0.0, 0.0},
                                              {-50.0, 0.0, 0.0, 0.0},
                                              {-90.0, -70.0, -65.0, 0.0},
                                              {-5.0, 3.0, -30.0, 1.0},
                                              {2.0, 2.0, 2.0, 2.0}};
  for (const Eigen::Vector4d& z : cases) {
    SCOPED_TRACE(testing::Message() << z.transpose());
    const BruteForce expected = Integrate(z);
    const BinghamIntegrals actual = ComputeBinghamIntegrals(z);
    EXPECT_NEAR(actual.log_normalizer, std::log(expected.normalizer), 1e-11);
    for (Eigen::Index i = 0; i < 4; ++i) {
      EXPECT_NEAR(actual.mean[i], expected.mean[i], 1e-11 * expected.mean[i]) << i;
      for (Eigen::Index j = 0; j < 4; ++j) {
        const double covariance = expected.second(i, j) - expected.mean[i] * expected.mean[j];
        EXPECT_NEAR(actual.covariance(i, j), covariance, 1e-11) << i << " " << j;
      }
    }
  }
}

/// Values of the integral with Bessel functions, integrated to 30 digits.
TEST(BinghamNormalizer, EqualsReferenceValuesWhenNarrow) {
  struct Reference {
    Eigen::Vector3d z;
    double log_normalizer;
    Eigen::Vector3d mean;
  };
  const std::vector<Reference> references = {
      {{-100, -70, -59.9},
       -4.0524605486021519753,
       {0.0050259368014989, 0.0071961544386192, 0.0084203168162542}},
      {{-100, -70, -60.1},
       -4.0541417815755225818,
       {0.0050259360122007, 0.0071961528047479, 0.0083920446209795}},
      {{-1000, -1, 0},
       -0.64253729677644295799,
       {0.00049987655911262, 0.25361217470223, 0.37294397436933}},
      {{-1000, -1000, -1000},
       -7.9506397809387974224,
       {0.00050025075320467, 0.00050025075320467, 0.00050025075320467}},
      {{-1e5, -1e5, -1e5},
       -14.859138688008793872,
       {5.00002500075e-6, 5.00002500075e-6, 5.00002500075e-6}},
      {{-1e5, -1e3, -1},
       -6.6659923527119393648,
       {5.0000189405197e-6, 0.0005001895327883, 0.37861639079382}},
      {{-1e5, -1, -0.5},
       -3.1198978543890259508,
       {4.9999966976654e-6, 0.27040990784905, 0.32709607869872}},
      {{-1e5, -60, -60},
       -7.432048198175729672,
       {5.0000254357105e-6, 0.0084058658394845, 0.0084058658394845}},
      {{-1e7, -1e7, -30},
       -15.399819538327007368,
       {5.0000002544783e-8, 5.0000002544783e-8, 0.016965218038944}}};
  for (const Reference& reference : references) {
    SCOPED_TRACE(testing::Message() << reference.z.transpose());
    const BinghamIntegrals actual =
        ComputeBinghamIntegrals({reference.z[0], reference.z[1], reference.z[2], 0.0});
    EXPECT_NEAR(actual.log_normalizer, reference.log_normalizer, 1e-10);
    for (Eigen::Index i = 0; i < 3; ++i) {
      EXPECT_NEAR(actual.mean[i], reference.mean[i], 1e-9 * reference.mean[i]) << i;
    }
  }
}

TEST(BinghamNormalizer, IsGaussianInTheLimit) {
  for (const double z : {-1e6, -1e8, -1e10, -1e15}) {
    const BinghamIntegrals narrow = ComputeBinghamIntegrals({z, 2.0 * z, 4.0 * z, 0.0});
    // Twice, for q and -q, the integral of a normal density.
    const double expected =
        std::log(2.0) + 1.5 * std::log(kPi) - 0.5 * std::log(8.0) - 1.5 * std::log(-z);
    EXPECT_NEAR(narrow.log_normalizer, expected, 2.0 / -z + 1e-13);
    EXPECT_NEAR(narrow.mean[0] * -z, 0.5, 2.0 / -z);
    EXPECT_NEAR(narrow.mean[2] * -z, 0.125, 2.0 / -z);
  }
}

TEST(BinghamNormalizer, DerivativesAreThoseOfTheNormalizer) {
  const std::vector<Eigen::Vector4d> cases = {
      {-7.0, -2.0, -0.3, 0.0}, {-300.0, -20.0, -1.0, 0.0}, {-500.0, -200.0, -90.0, 0.0}};
  for (const Eigen::Vector4d& z : cases) {
    const BinghamIntegrals at = ComputeBinghamIntegrals(z);
    for (Eigen::Index i = 0; i < 4; ++i) {
      const double h = 1e-4 * std::fmax(1.0, std::abs(z[i]));
      const BinghamIntegrals above = ComputeBinghamIntegrals(z + h * Eigen::Vector4d::Unit(i));
      const BinghamIntegrals below = ComputeBinghamIntegrals(z - h * Eigen::Vector4d::Unit(i));
      EXPECT_NEAR(
          (above.log_normalizer - below.log_normalizer) / (2.0 * h), at.mean[i], 1e-7 * at.mean[i]);
      const Eigen::Vector4d column = (above.mean - below.mean) / (2.0 * h);
      EXPECT_LT((column - at.covariance.col(i)).norm(), 1e-6 * at.covariance.col(i).norm());
    }
  }
}

TEST(BinghamNormalizer, IsContinuousWhereTheMethodChanges) {
  for (const double z1 : {-60.0, -1e3, -1e5}) {
    const BinghamIntegrals above = ComputeBinghamIntegrals({z1, -60.0, -60.0 + 1e-12, 0.0});
    const BinghamIntegrals below = ComputeBinghamIntegrals({z1, -60.0, -60.0, 0.0});
    EXPECT_NEAR(above.log_normalizer, below.log_normalizer, 1e-10);
    EXPECT_LT((above.mean - below.mean).norm(), 1e-10);
  }
}

}  // namespace
}  // namespace vantage
