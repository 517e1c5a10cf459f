#include "common/rng.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "common/so3.h"

namespace vantage {
namespace {

TEST(Rng, GivesThePublishedSequence) {
  // Output of O'Neill's pcg32-demo for seed 42, stream 54.
  Rng rng(42, 54);
  for (const uint32_t expected :
       {0xa15c02b7U, 0x7b47f409U, 0xba1d3330U, 0x83d2f293U, 0xbfa4784bU, 0xcbed606eU}) {
    EXPECT_EQ(rng.NextUint32(), expected);
  }
}

TEST(Rng, SeedsAndStreamsDiffer) {
  Rng first(1);
  Rng again(1);
  Rng other_seed(2);
  Rng other_stream(1, 1);
  int same_seed = 0;
  int same_stream = 0;
  for (int i = 0; i < 1000; ++i) {
    const uint32_t value = first.NextUint32();
    EXPECT_EQ(again.NextUint32(), value);
    same_seed += other_seed.NextUint32() == value ? 1 : 0;
    same_stream += other_stream.NextUint32() == value ? 1 : 0;
  }
  EXPECT_LE(same_seed, 1);
  EXPECT_LE(same_stream, 1);
}

TEST(Rng, BelowIsUniform) {
  Rng rng(5);
  constexpr uint32_t kBound = 7;
  constexpr int kDraws = 70'000;
  std::array<int, kBound> counts{};
  for (int i = 0; i < kDraws; ++i) {
    const uint32_t value = rng.Below(kBound);
    ASSERT_LT(value, kBound);
    ++counts[value];
  }
  double chi_squared = 0.0;
  for (const int count : counts) {
    const double expected = static_cast<double>(kDraws) / kBound;
    chi_squared += (count - expected) * (count - expected) / expected;
  }
  EXPECT_LT(chi_squared, 22.5);  // 99.9 % of chi-squared with 6 degrees of freedom
  EXPECT_EQ(rng.Below(1), 0U);
}

TEST(Rng, UniformFillsItsInterval) {
  Rng rng(6);
  constexpr int kDraws = 100'000;
  double sum = 0.0;
  double sum_of_squares = 0.0;
  for (int i = 0; i < kDraws; ++i) {
    const double value = rng.Uniform();
    ASSERT_GE(value, 0.0);
    ASSERT_LT(value, 1.0);
    sum += value;
    sum_of_squares += value * value;
  }
  EXPECT_NEAR(sum / kDraws, 0.5, 0.005);
  EXPECT_NEAR(sum_of_squares / kDraws, 1.0 / 3.0, 0.005);
  for (int i = 0; i < 1000; ++i) {
    const double value = rng.Uniform(-2.0, 3.0);
    ASSERT_GE(value, -2.0);
    ASSERT_LT(value, 3.0);
  }
}

TEST(Rng, NormalHasItsMoments) {
  Rng rng(7);
  constexpr int kDraws = 200'000;
  std::array<double, 4> moments{};
  int beyond_two = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double value = rng.Normal();
    double power = 1.0;
    for (double& moment : moments) moment += (power *= value) / kDraws;
    beyond_two += std::abs(value) > 2.0 ? 1 : 0;
  }
  EXPECT_NEAR(moments[0], 0.0, 0.01);
  EXPECT_NEAR(moments[1], 1.0, 0.015);
  EXPECT_NEAR(moments[2], 0.0, 0.03);
  EXPECT_NEAR(moments[3], 3.0, 0.1);
  EXPECT_NEAR(static_cast<double>(beyond_two) / kDraws, 0.0455, 0.002);
}

TEST(Rng, UnitVectorsAreUniformOnTheSphere) {
  Rng rng(8);
  constexpr int kDraws = 50'000;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  for (int i = 0; i < kDraws; ++i) {
    const Eigen::Vector3d v = rng.UnitVector();
    ASSERT_NEAR(v.norm(), 1.0, 1e-14);
    mean += v / kDraws;
    second += v * v.transpose() / kDraws;
  }
  EXPECT_LE(mean.norm(), 0.02);
  EXPECT_LE((second - Eigen::Matrix3d::Identity() / 3.0).norm(), 0.02);
}

TEST(Rng, RotationsAreUniformOverSo3) {
  Rng rng(9);
  constexpr int kDraws = 50'000;
  const Eigen::Quaterniond reference = ExpSo3({0.3, -1.0, 0.7});
  double mean_angle = 0.0;
  Eigen::Matrix3d mean = Eigen::Matrix3d::Zero();
  for (int i = 0; i < kDraws; ++i) {
    const Eigen::Quaterniond q = rng.Rotation();
    ASSERT_NEAR(q.norm(), 1.0, 1e-14);
    mean_angle += GeodesicAngle(reference, q) / kDraws;
    mean += q.toRotationMatrix() / kDraws;
  }
  // The angle's density is (1 - cos) / pi on [0, pi]: mean pi / 2 + 2 / pi.
  EXPECT_NEAR(mean_angle, std::numbers::pi / 2.0 + 2.0 / std::numbers::pi, 0.01);
  EXPECT_LE(mean.norm(), 0.03);
}

}  // namespace
}  // namespace vantage
