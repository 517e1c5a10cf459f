#include "common/statistics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace vantage {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::vector<double> Exponential(size_t count, Rng& rng) {
  std::vector<double> values(count);
  for (double& value : values) value = -std::log(1.0 - rng.Uniform());
  return values;
}

bool AllNan(const Interval& interval) {
  return std::isnan(interval.value) && std::isnan(interval.low) && std::isnan(interval.high);
}

// Equal to the last bit; false for NaN.
bool Same(const Interval& a, const Interval& b) {
  return a.value == b.value && a.low == b.low && a.high == b.high;
}

TEST(Statistics, QuantileEqualsThatOfTheSortedValues) {
  Rng rng(1);
  for (size_t count = 1; count <= 12; ++count) {
    const std::vector<double> values = Exponential(count, rng);
    std::vector<double> sorted = values;
    std::sort(sorted.begin(), sorted.end());
    for (const double q : {0.0, 0.025, 0.25, 0.5, 0.6, 0.975, 1.0}) {
      const double place = q * static_cast<double>(count - 1);
      const auto below = static_cast<size_t>(place);
      const size_t above = std::min(below + 1, count - 1);
      const double expected =
          sorted[below] + (place - std::floor(place)) * (sorted[above] - sorted[below]);
      EXPECT_NEAR(Quantile(values, q), expected, 1e-15) << count << " " << q;
    }
  }
  EXPECT_EQ(Median(std::vector<double>{4.0, 1.0, 2.0, 3.0}), 2.5);
  EXPECT_EQ(Mean(std::vector<double>{4.0, 1.0, 2.0, 3.0}), 2.5);
}

TEST(Statistics, NoValuesAndNanGiveNanInfinitiesDoNot) {
  EXPECT_TRUE(std::isnan(Median({})));
  EXPECT_TRUE(std::isnan(Mean({})));
  EXPECT_TRUE(std::isnan(Median(std::vector<double>{1.0, kNan, 2.0})));
  EXPECT_TRUE(std::isnan(Mean(std::vector<double>{1.0, kNan, 2.0})));
  EXPECT_EQ(Median(std::vector<double>{kInfinity, kInfinity, 1.0, kInfinity}), kInfinity);
  EXPECT_EQ(Median(std::vector<double>{kInfinity, 1.0, 0.0}), 1.0);
}

struct Scaled {
  double width = 1.0;  // of the interval about its value: 1 leaves it as it is
};

// How often the interval over `count` exponential values holds the truth.
double Coverage(Statistic statistic, double truth, Scaled scaled) {
  constexpr int kTrials = 500;
  Rng rng(7);
  int held = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const std::vector<double> values = Exponential(150, rng);
    const Interval interval = BootstrapInterval(values, statistic, {.resamples = 400}, rng);
    const double low = interval.value - scaled.width * (interval.value - interval.low);
    const double high = interval.value + scaled.width * (interval.high - interval.value);
    if (low <= truth && truth <= high) ++held;
  }
  return static_cast<double>(held) / kTrials;
}

// The share of 95 % that counts as right; the binomial deviation over 500 trials is 1 %, and the
// percentile interval of a skewed distribution is a little too narrow.
bool IsNominal(double coverage) { return coverage >= 0.92 && coverage <= 0.975; }

TEST(Statistics, IntervalHoldsTheTruthAsOftenAsItClaims) {
  for (const Statistic statistic : {Statistic::kMean, Statistic::kMedian}) {
    const double truth = statistic == Statistic::kMean ? 1.0 : std::numbers::ln2;
    const double coverage = Coverage(statistic, truth, {});
    EXPECT_TRUE(IsNominal(coverage)) << coverage;
    // Intervals that were too narrow, too wide or beside the truth do not pass.
    EXPECT_FALSE(IsNominal(Coverage(statistic, truth, {0.75})));
    EXPECT_FALSE(IsNominal(Coverage(statistic, truth, {1.4})));
    EXPECT_FALSE(IsNominal(Coverage(statistic, truth + 0.1, {})));
    EXPECT_FALSE(IsNominal(kNan));
  }
}

TEST(Statistics, IntervalOfAMeanIsThatOfItsStandardError) {
  Rng rng(2);
  std::vector<double> values(2000);
  double variance = 0.0;
  for (double& value : values) value = 3.0 + 0.5 * rng.Normal();
  const double mean = Mean(values);
  for (const double value : values) variance += (value - mean) * (value - mean) / 2000.0;
  const Interval interval = BootstrapInterval(values, Statistic::kMean, {}, rng);
  const double half_width = 1.959964 * std::sqrt(variance / 2000.0);
  EXPECT_EQ(interval.value, mean);
  EXPECT_NEAR(interval.high - mean, half_width, 0.1 * half_width);
  EXPECT_NEAR(mean - interval.low, half_width, 0.1 * half_width);

  // At 68.27 % it is one standard error.
  const Interval narrow = BootstrapInterval(values, Statistic::kMean, {.confidence = 0.6827}, rng);
  EXPECT_NEAR(narrow.high - narrow.low, 2.0 * half_width / 1.959964, 0.2 * half_width);
}

TEST(Statistics, RateIsTheMeanOfZerosAndOnes) {
  Rng rng(3);
  std::vector<double> wrong(1000, 0.0);
  std::fill(wrong.begin(), wrong.begin() + 100, 1.0);
  const Interval rate = BootstrapInterval(wrong, Statistic::kMean, {}, rng);
  const double half_width = 1.959964 * std::sqrt(0.1 * 0.9 / 1000.0);
  EXPECT_NEAR(rate.value, 0.1, 1e-15);
  EXPECT_NEAR(rate.high, 0.1 + half_width, 0.1 * half_width);
  EXPECT_NEAR(rate.low, 0.1 - half_width, 0.1 * half_width);
}

TEST(Statistics, SameSeedGivesTheSameInterval) {
  Rng rng(4);
  const std::vector<double> values = Exponential(300, rng);
  Rng first(5);
  Rng again(5);
  Rng other(6);
  const Interval a = BootstrapInterval(values, Statistic::kMedian, {.resamples = 100}, first);
  const Interval b = BootstrapInterval(values, Statistic::kMedian, {.resamples = 100}, again);
  const Interval c = BootstrapInterval(values, Statistic::kMedian, {.resamples = 100}, other);
  EXPECT_TRUE(Same(a, b));
  EXPECT_FALSE(Same(a, c));
  EXPECT_FALSE(Same({kNan, 0.0, 0.0}, {kNan, 0.0, 0.0}));
}

TEST(Statistics, PairingTakesOutWhatBothSamplesShare) {
  Rng rng(8);
  std::vector<double> easy(1000);
  std::vector<double> hard(1000);
  for (size_t i = 0; i < easy.size(); ++i) {
    const double shared = 10.0 * rng.Uniform();
    easy[i] = shared + 0.01 * rng.Normal();
    hard[i] = shared + 0.05 + 0.01 * rng.Normal();
  }
  for (const Statistic statistic : {Statistic::kMean, Statistic::kMedian}) {
    const Interval paired = PairedDifferenceInterval(hard, easy, statistic, {}, rng);
    EXPECT_NEAR(paired.value, 0.05, 0.002);
    EXPECT_LT(paired.low, paired.value);
    EXPECT_LT(paired.high - paired.low, 0.004);
    const Interval of_statistics = DifferenceInterval(hard, easy, statistic, {}, rng);
    EXPECT_EQ(of_statistics.value, Evaluate(statistic, hard) - Evaluate(statistic, easy));
    // Drawn separately it would be some 0.5 wide.
    EXPECT_LT(of_statistics.high - of_statistics.low, 0.05);
    EXPECT_GT(of_statistics.low, 0.0);
  }
  // Means are linear: both differences are the same but for rounding.
  Rng first(9);
  Rng again(9);
  const Interval a = PairedDifferenceInterval(hard, easy, Statistic::kMean, {}, first);
  const Interval b = DifferenceInterval(hard, easy, Statistic::kMean, {}, again);
  EXPECT_NEAR(a.low, b.low, 1e-12);
  EXPECT_NEAR(a.high, b.high, 1e-12);
}

TEST(Statistics, GroupsKeepTheirSizes) {
  Rng rng(10);
  std::vector<double> values;
  std::vector<int> groups;
  for (int i = 0; i < 900; ++i) {
    const int group = i % 3 == 0 ? 17 : -4;  // 300 and 600, interleaved
    groups.push_back(group);
    values.push_back((group == 17 ? 100.0 : 0.0) + rng.Normal());
  }
  const Interval whole = BootstrapInterval(values, Statistic::kMean, {}, rng);
  const Interval stratified = BootstrapInterval(values, Statistic::kMean, {.groups = groups}, rng);
  EXPECT_EQ(stratified.value, whole.value);
  // Between the groups lies a deviation of 100 sqrt(2) / 3, within them one of 1.
  const double between = 2.0 * 1.959964 * 100.0 * std::numbers::sqrt2 / 3.0 / std::sqrt(900.0);
  const double within = 2.0 * 1.959964 / std::sqrt(900.0);
  EXPECT_NEAR(whole.high - whole.low, between, 0.1 * between);
  EXPECT_NEAR(stratified.high - stratified.low, within, 0.12 * within);

  // A group of one value is always drawn once.
  const std::vector<double> alone = {1.0, 2.0, 3.0};
  const std::vector<int> apart = {0, 1, 2};
  const Interval fixed = BootstrapInterval(alone, Statistic::kMean, {.groups = apart}, rng);
  EXPECT_EQ(fixed.low, 2.0);
  EXPECT_EQ(fixed.high, 2.0);
}

TEST(Statistics, IntervalsOfNothingOrNanAreNan) {
  Rng rng(11);
  const std::vector<double> none;
  const std::vector<double> values = {1.0, 2.0, 3.0};
  const std::vector<double> broken = {1.0, kNan, 3.0};
  for (const Statistic statistic : {Statistic::kMean, Statistic::kMedian}) {
    EXPECT_TRUE(AllNan(BootstrapInterval(none, statistic, {}, rng)));
    EXPECT_TRUE(AllNan(BootstrapInterval(broken, statistic, {}, rng)));
    EXPECT_TRUE(AllNan(PairedDifferenceInterval(values, broken, statistic, {}, rng)));
    EXPECT_TRUE(AllNan(DifferenceInterval(values, broken, statistic, {}, rng)));
    EXPECT_TRUE(AllNan(DifferenceInterval(broken, values, statistic, {}, rng)));
    EXPECT_FALSE(AllNan(BootstrapInterval(values, statistic, {}, rng)));
  }
}

}  // namespace
}  // namespace vantage
