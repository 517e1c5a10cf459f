#include "fusion/bingham/bingham_mixture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "common/rng.h"
#include "common/so3.h"

namespace vantage {
namespace {

BinghamComponent Component(double weight, const Eigen::Quaterniond& q, double sigma) {
  return {std::log(weight), BinghamDistribution::Isotropic(q, sigma)};
}

Eigen::Quaterniond Near(const Eigen::Quaterniond& q, double sigma, Rng& rng) {
  return q * ExpSo3(sigma * Eigen::Vector3d(rng.Normal(), rng.Normal(), rng.Normal()));
}

double SumOfWeights(const BinghamMixture& mixture) {
  double sum = 0.0;
  for (const BinghamComponent& component : mixture.components()) {
    sum += std::exp(component.log_weight);
  }
  return sum;
}

TEST(BinghamMixture, ProductIsProportionalToThePointwiseProduct) {
  Rng rng(1);
  const BinghamMixture a({Component(3.0, rng.Rotation(), 0.5),
                          Component(1.0, rng.Rotation(), 1.0),
                          BinghamComponent{}});
  const BinghamMixture b({Component(0.95, rng.Rotation(), 0.4), {std::log(0.05), {}}});
  const BinghamMixture product = Multiply(a, b);
  EXPECT_EQ(product.components().size(), 6U);
  EXPECT_NEAR(SumOfWeights(product), 1.0, 1e-12);
  const Eigen::Quaterniond first = rng.Rotation();
  const double offset = a.LogDensity(first) + b.LogDensity(first) - product.LogDensity(first);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Quaterniond q = rng.Rotation();
    EXPECT_NEAR(a.LogDensity(q) + b.LogDensity(q) - product.LogDensity(q), offset, 1e-9);
  }
}

TEST(BinghamMixture, ModeIsTheHighestPlace) {
  Rng rng(2);
  for (int i = 0; i < 20; ++i) {
    const Eigen::Quaterniond q = rng.Rotation();
    std::vector<BinghamComponent> components{BinghamComponent{}};
    for (int k = 0; k < 5; ++k) components.push_back(Component(1.0, Near(q, 0.1, rng), 0.12));
    components.push_back(Component(1.0, rng.Rotation(), 0.12));
    const BinghamMixture mixture(components);
    const Eigen::Quaterniond mode = mixture.Mode();
    for (int k = 0; k < 2000; ++k) {
      const double sigma = std::pow(10.0, rng.Uniform(-4.0, 0.0));
      EXPECT_LE(mixture.LogDensity(Near(mode, sigma, rng)), mixture.LogDensity(mode) + 1e-12);
    }
  }
}

TEST(BinghamMixture, ReducingKeepsTheScatterAndTheUniformComponent) {
  Rng rng(3);
  std::vector<BinghamComponent> components{{std::log(0.1), {}}};
  for (int i = 0; i < 20; ++i) {
    components.push_back(Component(rng.Uniform(), rng.Rotation(), rng.Uniform(0.05, 0.5)));
  }
  BinghamMixture mixture(components);
  const auto scatter_of = [](const BinghamMixture& of) {
    Eigen::Matrix4d scatter = Eigen::Matrix4d::Zero();
    for (const BinghamComponent& component : of.components()) {
      scatter += std::exp(component.log_weight) * component.distribution.scatter();
    }
    return scatter;
  };
  const Eigen::Matrix4d before = scatter_of(mixture);
  const double uniform_weight = mixture.components().front().log_weight;
  for (const int count : {20, 13, 4, 1}) {
    mixture.Reduce(count);
    EXPECT_EQ(mixture.components().size(), static_cast<size_t>(count + 1));
    EXPECT_NEAR(SumOfWeights(mixture), 1.0, 1e-12);
    EXPECT_LT((scatter_of(mixture) - before).norm(), 1e-8);
    EXPECT_TRUE(mixture.components().front().distribution.is_uniform());
    EXPECT_NEAR(mixture.components().front().log_weight, uniform_weight, 1e-12);
  }
}

/// The pairs that are merged are those of the documented divergence, found here by trying all.
TEST(BinghamMixture, ReducingMergesTheMostAlikePairFirst) {
  Rng rng(4);
  for (int i = 0; i < 20; ++i) {
    std::vector<BinghamComponent> components;
    for (int k = 0; k < 8; ++k) {
      components.push_back(Component(1.0, rng.Rotation(), rng.Uniform(0.1, 0.5)));
    }
    BinghamMixture mixture(components);
    for (int left = 7; left >= 2; --left) {
      const std::vector<BinghamComponent> old = mixture.components();
      double smallest = 1e300;
      size_t a = 0;
      size_t b = 0;
      for (size_t j = 0; j < old.size(); ++j) {
        for (size_t k = 0; k < j; ++k) {
          const Eigen::Matrix4d& s = old[j].distribution.scatter();
          const Eigen::Matrix4d& t = old[k].distribution.scatter();
          const double divergence = std::log((0.5 * (s + t)).determinant()) -
                                    0.5 * std::log(s.determinant() * t.determinant());
          if (divergence < smallest) {
            smallest = divergence;
            a = j;
            b = k;
          }
        }
      }
      mixture.Reduce(left);
      for (size_t j = 0; j < old.size(); ++j) {
        const bool stays = std::any_of(
            mixture.components().begin(), mixture.components().end(), [&](const auto& component) {
              return component.distribution.matrix() == old[j].distribution.matrix();
            });
        EXPECT_EQ(stays, j != a && j != b) << left << ": " << j;
      }
    }
  }
}

TEST(BinghamMixture, ReducingDropsWhatCannotComeBack) {
  Rng rng(5);
  BinghamMixture mixture({{0.0, BinghamDistribution::Isotropic(rng.Rotation(), 0.1)},
                          {-999.0, BinghamDistribution::Isotropic(rng.Rotation(), 0.1)},
                          {-1001.0, BinghamDistribution::Isotropic(rng.Rotation(), 0.1)},
                          {-5000.0, BinghamDistribution()}});
  mixture.Reduce(10);
  ASSERT_EQ(mixture.components().size(), 3U);
  EXPECT_TRUE(mixture.components().front().distribution.is_uniform());
}

}  // namespace
}  // namespace vantage
