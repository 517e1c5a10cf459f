#include "fusion/compared/particle_filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace vantage {
namespace {

Eigen::Quaterniond Noisy(const Eigen::Quaterniond& q, double sigma, Rng& rng) {
  return q * ExpSo3(sigma * Eigen::Vector3d(rng.Normal(), rng.Normal(), rng.Normal()));
}

Eigen::Quaterniond Particle(const ParticleArrays& p, size_t i) {
  return Eigen::Quaternionf(p.w[i], p.x[i], p.y[i], p.z[i]).cast<double>().normalized();
}

ParticleArrays Spread(size_t count) {
  ParticleArrays particles(count);
  SpreadEvenly(Eigen::Quaterniond(0.6, 0.0, 0.8, 0.0), &particles);
  return particles;
}

TEST(ParticleArrays, WeightsAreThoseOfThePlainFormula) {
  Rng rng(1);
  for (const double sigma_deg : {0.1, 1.0, 4.0, 20.0, 45.0}) {
    const double sigma = sigma_deg * kDegree;
    const Eigen::Quaterniond q = rng.Rotation();
    ParticleArrays particles = Spread(1003);  // No whole number of blocks or lanes.
    // Some that are near, at the detection itself and opposite to it, of both signs.
    for (size_t i = 0; i < 300; ++i) {
      Eigen::Quaterniond near = i == 0 ? q : Noisy(q, sigma, rng);
      if (i == 1) near = q * ExpSo3({std::numbers::pi, 0.0, 0.0});
      const Eigen::Vector4f p = ((i % 2 == 0 ? 1.0 : -1.0) * near.coeffs()).cast<float>();
      particles.x[i] = p[0];
      particles.y[i] = p[1];
      particles.z[i] = p[2];
      particles.w[i] = p[3];
      particles.weight[i] = static_cast<float>(rng.Uniform());
    }
    const ParticleArrays before = particles;
    const WeightSums sums = MultiplyByConfidence(q, sigma, 1e-3F, 2.0F, &particles);
    WeightSums expected;
    for (size_t i = 0; i < particles.size(); ++i) {
      // Particles are of single precision, and so is their angle.
      const double angle = GeodesicAngle(Particle(before, i), q);
      const double factor = 2.0 * (std::exp(-angle * angle / (2.0 * sigma * sigma)) + 1e-3);
      const double weight = static_cast<double>(before.weight[i]) * factor;
      const double slack = 3e-7 * angle / (sigma * sigma) + 2e-5;
      EXPECT_NEAR(particles.weight[i], weight, slack * weight + 1e-12) << i << " " << sigma_deg;
      expected.sum += static_cast<double>(particles.weight[i]);
      expected.sum_of_squares +=
          static_cast<double>(particles.weight[i]) * static_cast<double>(particles.weight[i]);
    }
    EXPECT_NEAR(sums.sum, expected.sum, 1e-6 * expected.sum);
    EXPECT_NEAR(sums.sum_of_squares, expected.sum_of_squares, 1e-6 * expected.sum_of_squares);
  }
}

TEST(ParticleArrays, SpreadIsEven) {
  const ParticleArrays particles = Spread(20000);
  Rng rng(2);
  for (int trial = 0; trial < 10; ++trial) {
    // A ball of radius r holds (r - sin r) / pi of SO(3).
    const double radius = 40.0 * kDegree;
    const double expected = 20000.0 * (radius - std::sin(radius)) / std::numbers::pi;
    const Eigen::Quaterniond center = rng.Rotation();
    int inside = 0;
    for (size_t i = 0; i < particles.size(); ++i) {
      EXPECT_NEAR(
          Eigen::Vector4f(particles.x[i], particles.y[i], particles.z[i], particles.w[i]).norm(),
          1.0F,
          1e-6F);
      if (GeodesicAngle(Particle(particles, i), center) < radius) ++inside;
    }
    EXPECT_NEAR(inside, expected, 0.05 * expected);
  }
}

TEST(ParticleArrays, EachParticleIsDrawnAsOftenAsItsWeightSays) {
  Rng rng(3);
  constexpr size_t kCount = 1001;
  SystematicResampler resampler(kCount, rng);
  for (const bool few_heavy : {false, true}) {
    ParticleArrays particles = Spread(kCount);
    double sum = 0.0;
    for (size_t i = 0; i < kCount; ++i) {
      particles.weight[i] =
          few_heavy && i % 100 != 7 ? 0.0F : static_cast<float>(10.0 * rng.Uniform());
      sum += static_cast<double>(particles.weight[i]);
    }
    const ParticleArrays before = particles;
    resampler.Resample(sum, 0.0, rng, &particles);
    size_t i = 0;
    std::vector<int> copies(kCount, 0);
    for (size_t j = 0; j < kCount; ++j) {
      while (i < kCount && GeodesicAngle(Particle(before, i), Particle(particles, j)) > 1e-5) ++i;
      ASSERT_LT(i, kCount) << "draws are in the order of the particles";
      ++copies[i];
      EXPECT_EQ(particles.weight[j], 1.0F);
    }
    for (size_t n = 0; n < kCount; ++n) {
      const double expected = static_cast<double>(before.weight[n]) / sum * kCount;
      EXPECT_LT(std::abs(copies[n] - expected), 1.0 + 1e-6) << n;
    }
  }
}

TEST(ParticleArrays, JitterHasItsWidthAboutEachAxis) {
  Rng rng(4);
  constexpr size_t kCount = 20000;
  const double jitter = 2.0 * kDegree;
  SystematicResampler resampler(kCount, rng);
  ParticleArrays particles = Spread(kCount);
  const ParticleArrays before = particles;
  resampler.Resample(static_cast<double>(kCount), jitter, rng, &particles);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (size_t i = 0; i < kCount; ++i) {
    const Eigen::Vector3d turn = LogSo3(Particle(before, i).conjugate() * Particle(particles, i));
    mean += turn / kCount;
    covariance += turn * turn.transpose() / kCount;
  }
  EXPECT_LT(mean.norm(), 0.05 * jitter);
  EXPECT_LT((covariance / (jitter * jitter) - Eigen::Matrix3d::Identity()).norm(), 0.08);
}

TEST(ParticleFilter, AgreesWithTheExactPosteriorMean) {
  // Without outliers the posterior of normal errors is normal about their mean.
  Rng rng(5);
  double worst = 0.0;
  for (int trial = 0; trial < 5; ++trial) {
    const Eigen::Quaterniond truth = rng.Rotation();
    ParticleFilter filter({.num_particles = 100000,
                           .sigma_cw = 8.0 * kDegree,
                           .outlier_share = 1e-6,
                           .jitter = 0.3 * kDegree,
                           .seed = static_cast<uint64_t>(trial)});
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    constexpr int kViews = 8;
    for (int i = 0; i < kViews; ++i) {
      const Eigen::Vector3d error =
          8.0 * kDegree * Eigen::Vector3d(rng.Normal(), rng.Normal(), rng.Normal());
      sum += error;
      ASSERT_TRUE(filter.Add({truth * ExpSo3(error), 0.0}).ok());
    }
    const Eigen::Quaterniond exact = truth * ExpSo3(sum / kViews);
    worst = std::max(worst, GeodesicAngle(filter.Estimate().value(), exact));
    // Its width: sigma / sqrt(n) about each axis, and the jitter's.
    double variance = 0.0;
    for (size_t i = 0; i < filter.num_particles(); ++i) {
      const double angle = GeodesicAngle(filter.particle(i), exact);
      variance += filter.weight(i) * angle * angle / 3.0;
    }
    EXPECT_NEAR(std::sqrt(variance), 8.0 * kDegree / std::sqrt(8.0), 0.5 * kDegree);
  }
  // Half the posterior's own deviation about one axis: the first view leaves some 150 effective
  // particles, which is what their mean can be told from.
  EXPECT_LT(worst, 0.5 * 8.0 * kDegree / std::sqrt(8.0));
}

TEST(ParticleFilter, SharesOfTwoModesAreThoseOfTheExactPosterior) {
  // Each view multiplies by (1 - e) G / Z + e.
  const Eigen::Quaterniond a = Eigen::Quaterniond::Identity();
  const Eigen::Quaterniond b = ExpSo3({0.0, 0.0, 2.0});
  ParticleFilter filter({.num_particles = 200000, .sigma_cw = 10.0 * kDegree, .jitter = 0.0});
  ASSERT_TRUE(filter.Add({a, 0.0}).ok());
  ASSERT_TRUE(filter.Add({b, 0.0}).ok());
  const double e = 0.1;
  const double sigma = 10.0 * kDegree;
  // G G of modes this far apart is nothing: mass e (1 - e) near each, e^2 spread evenly.
  double near_a = 0.0;
  double near_b = 0.0;
  const double radius = 4.0 * sigma;
  for (size_t i = 0; i < filter.num_particles(); ++i) {
    if (GeodesicAngle(filter.particle(i), a) < radius) near_a += filter.weight(i);
    if (GeodesicAngle(filter.particle(i), b) < radius) near_b += filter.weight(i);
  }
  const double even = e * e * (radius - std::sin(radius)) / std::numbers::pi;
  const double share = (e * (1.0 - e) + even) / (2.0 * e * (1.0 - e) + e * e);
  EXPECT_NEAR(near_a, share, 0.08);
  EXPECT_NEAR(near_b, share, 0.08);
}

TEST(ParticleFilter, FindsTheTruthAmongOutliers) {
  Rng rng(6);
  int found = 0;
  for (int trial = 0; trial < 10; ++trial) {
    const Eigen::Quaterniond truth = rng.Rotation();
    ParticleFilter filter({.num_particles = 100000, .seed = static_cast<uint64_t>(trial)});
    for (int i = 0; i < 20; ++i) {
      const Eigen::Quaterniond q = i % 5 == 2 ? rng.Rotation() : Noisy(truth, 2.0 * kDegree, rng);
      ASSERT_TRUE(filter.Add({q, 0.0}).ok());
    }
    const Eigen::Quaterniond estimate = filter.Estimate().value();
    EXPECT_EQ(estimate.coeffs(), Canonical(estimate).coeffs());
    if (GeodesicAngle(estimate, truth) < 2.5 * kDegree) ++found;
  }
  EXPECT_EQ(found, 10);
}

TEST(ParticleFilter, EffectiveSampleSizeIsThatOfTheWeights) {
  Rng rng(7);
  const Eigen::Quaterniond q = rng.Rotation();
  ParticleFilter filter({.num_particles = 50000});
  EXPECT_EQ(filter.effective_sample_size(), 50000.0);
  for (int view = 0; view < 6; ++view) {
    ASSERT_TRUE(filter.Add({Noisy(q, kDegree, rng), 0.0}).ok());
    double sum = 0.0;
    double squares = 0.0;
    for (size_t i = 0; i < filter.num_particles(); ++i) {
      sum += filter.weight(i);
      squares += filter.weight(i) * filter.weight(i);
    }
    EXPECT_NEAR(sum, 1.0, 1e-5);
    EXPECT_NEAR(filter.effective_sample_size(), 1.0 / squares, 1e-4 / squares);
    EXPECT_GE(filter.effective_sample_size(), 25000.0);  // Resampled below that.
  }
}

TEST(ParticleFilter, TheSeedFixesTheResultTheSignDoesNotMatter) {
  const auto run = [](uint64_t seed, double sign) {
    Rng rng(8);
    const Eigen::Quaterniond truth = rng.Rotation();
    ParticleFilter filter({.num_particles = 30000, .seed = seed});
    for (int i = 0; i < 6; ++i) {
      const Eigen::Quaterniond q = Noisy(truth, 3.0 * kDegree, rng);
      EXPECT_TRUE(filter.Add({Eigen::Quaterniond(sign * q.coeffs()), 0.0}).ok());
    }
    return filter.Estimate().value();
  };
  const Eigen::Quaterniond first = run(1, 1.0);
  EXPECT_EQ(first.coeffs(), run(1, 1.0).coeffs());
  EXPECT_NE(first.coeffs(), run(2, 1.0).coeffs());
  EXPECT_EQ(first.coeffs(), run(1, -1.0).coeffs());
}

TEST(ParticleFilter, BadViewsChangeNothingAndParametersAreChecked) {
  Rng rng(9);
  const Eigen::Quaterniond q = rng.Rotation();
  ParticleFilter filter({.num_particles = 20000});
  EXPECT_FALSE(filter.Estimate().ok());
  ASSERT_TRUE(filter.Add({Eigen::Quaterniond(1.0009 * q.coeffs()), 0.0}).ok());
  const Eigen::Quaterniond before = filter.Estimate().value();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(filter.Add({Eigen::Quaterniond(1.1 * q.coeffs()), 0.0}).ok());
  EXPECT_FALSE(filter.Add({Eigen::Quaterniond(nan, nan, nan, nan), 0.0}).ok());
  EXPECT_FALSE(filter.Add({q, -1.0}).ok());
  EXPECT_EQ(filter.Estimate().value().coeffs(), before.coeffs());

  using P = ParticleFilterParameters;
  EXPECT_TRUE(P{}.Validate().ok());
  for (const int count : {0, -5, 2000000000}) {
    EXPECT_FALSE(P{.num_particles = count}.Validate().ok());
  }
  for (const double sigma : {0.0, 1e-4, 1.0, nan}) {
    EXPECT_FALSE(P{.sigma_cw = sigma}.Validate().ok());
  }
  for (const double share : {0.0, 1.0, nan}) {
    EXPECT_FALSE(P{.outlier_share = share}.Validate().ok());
  }
  for (const double jitter : {-0.1, 0.2, nan}) EXPECT_FALSE(P{.jitter = jitter}.Validate().ok());
  for (const int count : {1, 2, 7}) {
    ParticleFilter few({.num_particles = count});
    ASSERT_TRUE(few.Add({q, 0.0}).ok());
    EXPECT_NEAR(few.Estimate().value().norm(), 1.0, 1e-9);
  }
}

}  // namespace
}  // namespace vantage
