#include "fusion/confusion/confidence_sequence.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "common/rng.h"
#include "fusion/confusion/trial_count.h"

namespace vantage {
namespace {

constexpr int kTrials = 2000;

// Share of runs in which the true share is within the interval after each of kTrials trials.
template <class IntervalOf>
double PathCoverage(double p, int runs, uint64_t seed, IntervalOf&& interval_of) {
  std::map<std::pair<int, int>, bool> holds;  // Runs share most of their way.
  Rng rng(seed);
  int covered = 0;
  for (int run = 0; run < runs; ++run) {
    int s = 0;
    bool always = true;
    for (int n = 1; n <= kTrials && always; ++n) {
      s += rng.Uniform() < p ? 1 : 0;
      const auto [place, is_new] = holds.try_emplace({n, s}, false);
      if (is_new) {
        const Interval interval = interval_of(s, n);
        place->second = interval.low <= p && p <= interval.high;
      }
      always = place->second;
    }
    covered += always ? 1 : 0;
  }
  return covered / static_cast<double>(runs);
}

TEST(ConfidenceSequence, HoldsTheShareAtAllTimes) {
  constexpr int kRuns = 150;
  const double slack = 3.0 * std::sqrt(0.05 * 0.95 / kRuns);
  for (const double p : {0.02, 0.1, 0.5}) {
    const double coverage =
        PathCoverage(p, kRuns, 1, [](int s, int n) { return ConfidenceSequence(s, n); });
    EXPECT_GE(coverage, 0.95 - slack) << p;
  }
}

// The reason for it: intervals of fixed numbers of trials miss the share now and then.
TEST(ConfidenceSequence, JeffreysIntervalsDoNot) {
  for (const double p : {0.1, 0.5}) {
    const double coverage =
        PathCoverage(p, 40, 2, [](int s, int n) { return JeffreysInterval(s, n); });
    EXPECT_LT(coverage, 0.8) << p;
  }
}

// Against the likelihood ratio by quadrature over the mixture, p = sin^2 t.
TEST(ConfidenceSequence, BoundsAreWhereTheLikelihoodRatioIsOneByAlpha) {
  for (const int n : {1, 5, 40, 200}) {
    for (const int s : {0, 1, n / 2, n}) {
      for (const double alpha : {0.01, 0.05, 0.4}) {
        const Interval interval = ConfidenceSequence(s, n, alpha);
        double mixture = 0.0;
        constexpr int kSteps = 20'000;
        for (int i = 0; i < kSteps; ++i) {
          const double t = 0.5 * 3.141592653589793 * (i + 0.5) / kSteps;
          mixture += std::pow(std::sin(t), 2 * s) * std::pow(std::cos(t), 2 * (n - s)) / kSteps;
        }
        for (const double p : {interval.low, interval.high}) {
          if (p == 0.0 || p == 1.0) continue;
          const double likelihood = std::pow(p, s) * std::pow(1.0 - p, n - s);
          EXPECT_NEAR(mixture / likelihood * alpha, 1.0, 1e-4) << s << " of " << n;
        }
        EXPECT_LE(interval.low, interval.value);
        EXPECT_GE(interval.high, interval.value);
        const Interval mirrored = ConfidenceSequence(n - s, n, alpha);
        EXPECT_NEAR(mirrored.low, 1.0 - interval.high, 1e-12);
      }
    }
  }
}

TEST(ConfidenceSequence, KnowsNothingWithoutTrialsAndMoreWithEach) {
  const Interval none = ConfidenceSequence(0, 0);
  EXPECT_EQ(none.low, 0.0);
  EXPECT_EQ(none.high, 1.0);
  double last = 1.0;
  for (int n = 1; n < 300; ++n) {
    const Interval interval = ConfidenceSequence(0, n);
    EXPECT_EQ(interval.low, 0.0);
    EXPECT_LE(interval.high, last);
    last = interval.high;
  }
  EXPECT_LT(ConfidenceSequence(500'000'000, 1'000'000'000).high, 0.5002);
  // The price of looking at any time: wider than the interval of a fixed number.
  EXPECT_GT(ConfidenceSequence(20, 100).high, JeffreysInterval(20, 100).high);
}

// What the stopping rule relies on: the share nearest to one half is known least.
TEST(ConfidenceSequence, IsWidestAtOneHalf) {
  for (const int n : {24, 69, 135, 250}) {
    double last = 0.0;
    for (int s = 0; s <= n / 2; ++s) {
      const Interval interval = ConfidenceSequence(s, n);
      EXPECT_GE(interval.high - interval.low, last) << s << " of " << n;
      last = interval.high - interval.low;
    }
  }
}

}  // namespace
}  // namespace vantage
