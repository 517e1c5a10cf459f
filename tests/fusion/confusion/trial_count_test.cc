#include "fusion/confusion/trial_count.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "common/rng.h"

namespace vantage {
namespace {

// Posterior probability of a share above `share` after n trials without success: the integral of
// Beta(1/2, n + 1/2)'s density by the substitution p = sin^2 t, which leaves cos^2n t.
double TailByQuadrature(int n, double share) {
  const auto integral = [n](double from, double to) {
    constexpr int kSteps = 20'000;
    double sum = 0.0;
    for (int i = 0; i < kSteps; ++i) {
      sum += std::pow(std::cos(from + (to - from) * (i + 0.5) / kSteps), 2 * n);
    }
    return sum * (to - from) / kSteps;
  };
  const double at = std::asin(std::sqrt(share));
  const double tail = integral(at, std::numbers::pi / 2);
  return tail / (integral(0.0, at) + tail);
}

TEST(NumTrials, IsWhatEquation11Gives) {
  EXPECT_EQ(NumTrials(8480), 200);
  EXPECT_EQ(NumTrials(68416), 239);
  EXPECT_EQ(NumTrials(548496), 279);
  EXPECT_LT(NumTrials(8480), kPaperNumTrials);
}

TEST(NumTrials, IsTheFewestThatAreEnough) {
  for (const int num_cells : {1, 10, 8480}) {
    for (const double alpha : {0.01, 0.05, 0.3}) {
      for (const double share : {0.02, 0.05, 0.2}) {
        const int n = NumTrials(num_cells, alpha, share);
        EXPECT_LE(TailByQuadrature(n, share), alpha / num_cells * (1.0 + 1e-3)) << n;
        EXPECT_GT(TailByQuadrature(n - 1, share), alpha / num_cells * (1.0 - 1e-3)) << n;
      }
    }
  }
  EXPECT_EQ(NumTrials(1, 0.9, 0.9), 0);  // The prior alone.
}

TEST(JeffreysInterval, HoldsTheShareAndIsSymmetric) {
  for (const int trials : {1, 7, 250}) {
    double last_low = -1.0;
    for (int s = 0; s <= trials; ++s) {
      const Interval interval = JeffreysInterval(s, trials);
      EXPECT_DOUBLE_EQ(interval.value, static_cast<double>(s) / trials);
      EXPECT_LE(interval.low, interval.value);
      EXPECT_GE(interval.high, interval.value);
      EXPECT_GE(interval.low, last_low);
      last_low = interval.low;
      const Interval mirrored = JeffreysInterval(trials - s, trials);
      EXPECT_NEAR(mirrored.low, 1.0 - interval.high, 1e-9);
      EXPECT_LT(JeffreysInterval(s, trials, 0.5).high, interval.high + 1e-12);
    }
  }
  EXPECT_EQ(JeffreysInterval(0, 10).low, 0.0);
  EXPECT_EQ(JeffreysInterval(10, 10).high, 1.0);
  // Brown, Cai and DasGupta 2001: 0 of 10 gives 0 to 0.217.
  EXPECT_NEAR(JeffreysInterval(0, 10).high, 0.217, 5e-4);
}

TEST(JeffreysInterval, CoversAboutAsOftenAsItSays) {
  Rng rng(1);
  for (const double p : {0.1, 0.3, 0.5}) {
    int held = 0;
    constexpr int kRuns = 4000;
    for (int run = 0; run < kRuns; ++run) {
      int s = 0;
      for (int i = 0; i < 100; ++i) s += rng.Uniform() < p ? 1 : 0;
      const Interval interval = JeffreysInterval(s, 100);
      held += interval.low <= p && p <= interval.high ? 1 : 0;
    }
    EXPECT_NEAR(held / static_cast<double>(kRuns), 0.95, 0.03) << p;
  }
}

}  // namespace
}  // namespace vantage
