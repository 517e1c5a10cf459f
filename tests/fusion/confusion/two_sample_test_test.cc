#include "fusion/confusion/two_sample_test.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "common/so3.h"
#include "fusion/confusion/predicted_row.h"
#include "fusion/confusion/several_tests.h"

namespace vantage {
namespace {

constexpr int kPermutations = 99;

Eigen::Quaterniond AboutZ(double angle_deg) {
  return ExpSo3(angle_deg * kDegree * Eigen::Vector3d::UnitZ());
}

// Two modes half a turn apart, errors of 1 deg, some missed.
struct Source {
  double flipped = 0.3;
  double missed = 0.05;
  Eigen::Quaterniond offset = Eigen::Quaterniond::Identity();

  std::vector<TrialOutcome> Draw(int count, Rng& rng) const {
    std::vector<TrialOutcome> outcomes;
    for (int i = 0; i < count; ++i) {
      if (rng.Uniform() < missed) {
        outcomes.push_back(std::nullopt);
        continue;
      }
      const Eigen::Vector3d error(rng.Normal(), rng.Normal(), rng.Normal());
      outcomes.push_back(AboutZ(rng.Uniform() < flipped ? 180.0 : 0.0) * offset *
                         ExpSo3(1.0 * kDegree * error));
    }
    return outcomes;
  }
};

// Share of runs that reject at 5 %.
double Power(const Source& a, const Source& b, int count, uint64_t seed) {
  Rng rng(seed);
  int rejected = 0;
  constexpr int kRuns = 60;
  for (int run = 0; run < kRuns; ++run) {
    const auto test = EnergyTest(a.Draw(count, rng), b.Draw(count, rng), kPermutations, rng);
    rejected += test->p_value <= 0.05 ? 1 : 0;
  }
  return rejected / static_cast<double>(kRuns);
}

double ChordOf(const TrialOutcome& a, const TrialOutcome& b) {
  if (!a && !b) return 0.0;
  return a && b ? std::sin(0.5 * GeodesicAngle(*a, *b)) : 1.0;
}

TEST(EnergyTest, StatisticIsTheEnergyDistance) {
  Rng rng(1);
  Source other;
  other.flipped = 0.6;
  const auto a = Source().Draw(31, rng);
  const auto b = other.Draw(50, rng);
  const auto mean = [](const auto& x, const auto& y) {
    double sum = 0.0;
    for (const TrialOutcome& i : x) {
      for (const TrialOutcome& j : y) sum += ChordOf(i, j);
    }
    return sum / static_cast<double>(x.size() * y.size());
  };
  const double expected = 2.0 * mean(a, b) - mean(a, a) - mean(b, b);
  EXPECT_NEAR(EnergyTest(a, b, 1, rng)->statistic, expected, 1e-6);
  EXPECT_NEAR(EnergyTest(b, a, 1, rng)->statistic, expected, 1e-6);
  EXPECT_NEAR(EnergyTest(a, a, 1, rng)->statistic, 0.0, 1e-6);
}

TEST(EnergyTest, PValuesAreUniformWhenNothingDiffers) {
  Rng rng(2);
  std::vector<double> p_values;
  for (int run = 0; run < 400; ++run) {
    const auto test =
        EnergyTest(Source().Draw(25, rng), Source().Draw(40, rng), kPermutations, rng);
    // p values are hundredths: spread over the step they stand for.
    p_values.push_back(test->p_value - rng.Uniform() / (kPermutations + 1));
  }
  const SeveralTests all = Combine(p_values);
  EXPECT_GT(all.uniformity_p, 0.01);
  EXPECT_NEAR(all.num_rejected, 20, 14);
}

// With 100 outcomes a side: the power that the documentation may promise.
TEST(EnergyTest, FindsWhatDiffers) {
  Source shares;
  shares.flipped = 0.6;
  EXPECT_GT(Power(Source(), shares, 100, 3), 0.9);  // 30 % against 60 %.
  Source missed;
  missed.missed = 0.3;
  EXPECT_GT(Power(Source(), missed, 100, 4), 0.8);  // 5 % against 30 %.
  Source one;
  one.flipped = 0.0;
  one.missed = 0.0;
  Source shifted = one;
  shifted.offset = AboutZ(1.0);
  EXPECT_GT(Power(one, shifted, 100, 5), 0.9);  // By the errors' deviation.
  EXPECT_LT(Power(Source(), Source(), 100, 6), 0.16);
}

TEST(EnergyTest, TheSameSeedGivesTheSame) {
  Rng rng(7);
  const auto a = Source().Draw(20, rng);
  const auto b = Source().Draw(30, rng);
  Rng first(8);
  Rng second(8);
  EXPECT_EQ(EnergyTest(a, b, 50, first)->p_value, EnergyTest(a, b, 50, second)->p_value);
}

TEST(EnergyTest, EqualOutcomesAreNoEvidence) {
  Rng rng(9);
  const std::vector<TrialOutcome> same(30, Eigen::Quaterniond::Identity());
  EXPECT_EQ(EnergyTest(same, same, 50, rng)->p_value, 1.0);
  const std::vector<TrialOutcome> none(30);
  EXPECT_EQ(EnergyTest(none, none, 50, rng)->p_value, 1.0);
  EXPECT_NEAR(EnergyTest(none, same, 50, rng)->p_value, 1.0 / 51.0, 1e-12);
  EXPECT_NEAR(EnergyTest(none, same, 50, rng)->statistic, 2.0, 1e-6);
}

TEST(EnergyTest, RefusesWhatCannotBeCompared) {
  Rng rng(10);
  const auto some = Source().Draw(5, rng);
  EXPECT_FALSE(EnergyTest({}, some, 10, rng).ok());
  EXPECT_FALSE(EnergyTest(some, {}, 10, rng).ok());
  EXPECT_FALSE(EnergyTest(some, std::vector<TrialOutcome>(kMostOutcomes + 1), 10, rng).ok());
  DirectionTrials huge;
  huge.trials = huge.missed = std::numeric_limits<int32_t>::max();
  EXPECT_FALSE(OutcomesOf(huge).ok());
  RowTrials row;
  row.trials = row.missed = std::numeric_limits<int32_t>::max();
  EXPECT_FALSE(OutcomesOf(row, So3Grid(2)).ok());
}

TEST(OutcomesOf, AreOneForEachTrial) {
  const So3Grid grid(8);
  DirectionTrials direction;
  direction.trials = 10;
  direction.missed = 2;
  direction.differences = {{{0, 0, 0}, 5}, {{0, 0, 360}, 3}};
  const auto outcomes = OutcomesOf(direction);
  ASSERT_TRUE(outcomes.ok());
  ASSERT_EQ(outcomes->size(), 10U);
  EXPECT_FALSE((*outcomes)[1].has_value());
  EXPECT_NEAR(GeodesicAngle(*(*outcomes)[9], AboutZ(90.0)), 0.0, 1e-9);

  Rng rng(11);
  const Eigen::Quaterniond q_truth = rng.Rotation();
  const RowTrials row = PredictedRow(direction, grid, q_truth);
  EXPECT_EQ(row.trials, 10);
  EXPECT_EQ(row.missed, 2);
  ASSERT_EQ(row.detected.size(), 2U);
  EXPECT_LT(row.detected[0].ordinal, row.detected[1].ordinal);
  const auto of_row = OutcomesOf(row, grid);
  ASSERT_TRUE(of_row.ok());
  ASSERT_EQ(of_row->size(), 10U);
  int at_truth = 0;
  for (const TrialOutcome& outcome : *of_row) {
    at_truth += outcome && GeodesicAngle(*outcome, q_truth) < 15.0 * kDegree ? 1 : 0;
  }
  EXPECT_EQ(at_truth, 5);
}

// Differences that fall into one cell are added up.
TEST(PredictedRow, CountsByCell) {
  const So3Grid grid(8);
  Rng rng(12);
  DirectionTrials direction;
  for (int16_t i = 0; i < 200; ++i) direction.differences.push_back({{0, 0, i}, 1 + i});
  direction.trials = 200 * 201 / 2;
  const Eigen::Quaterniond q_truth = rng.Rotation();
  const RowTrials row = PredictedRow(direction, grid, q_truth);
  int64_t sum = 0;
  for (size_t i = 0; i < row.detected.size(); ++i) {
    if (i > 0) {
      EXPECT_LT(row.detected[i - 1].ordinal, row.detected[i].ordinal);
    }
    sum += row.detected[i].count;
  }
  EXPECT_EQ(sum, direction.trials);
  EXPECT_LT(row.detected.size(), 30U);
}

}  // namespace
}  // namespace vantage
