#include "drivers/clock/rate_limiter.h"

#include <gtest/gtest.h>

#include "common/rng.h"

namespace vantage {
namespace {

int CountAccepted(RateLimiter& limiter, double frames_hz, double seconds, double jitter_us) {
  Rng rng(5);
  int accepted = 0;
  for (int i = 0; i < static_cast<int>(frames_hz * seconds); ++i) {
    const double time = 1e6 * i / frames_hz + rng.Uniform(-jitter_us, jitter_us);
    accepted += limiter.Accept(1'700'000'000'000'000 + static_cast<int64_t>(time)) ? 1 : 0;
  }
  return accepted;
}

TEST(RateLimiter, PassesEverythingWithoutALimit) {
  for (const double rate : {0.0, -1.0}) {
    RateLimiter limiter(rate);
    EXPECT_EQ(CountAccepted(limiter, 30.0, 10.0, 1000.0), 300);
  }
}

TEST(RateLimiter, KeepsTheMeanRate) {
  for (const double rate : {1.0, 7.0, 10.0, 15.0, 20.0}) {
    RateLimiter limiter(rate);
    EXPECT_NEAR(CountAccepted(limiter, 30.0, 60.0, 2000.0), 60.0 * rate, 0.02 * 60.0 * rate + 1.0)
        << rate;
  }
}

TEST(RateLimiter, PassesAllOfASlowerCamera) {
  RateLimiter limiter(30.0);
  EXPECT_EQ(CountAccepted(limiter, 10.0, 10.0, 2000.0), 100);
}

TEST(RateLimiter, TakesEveryThirdOf30At10Hz) {
  RateLimiter limiter(10.0);
  for (int64_t i = 0; i < 300; ++i) EXPECT_EQ(limiter.Accept(33'333 * i), i % 3 == 0) << i;
}

TEST(RateLimiter, StartsAnewAfterASteppedClock) {
  RateLimiter limiter(10.0);
  EXPECT_TRUE(limiter.Accept(1'000'000'000));
  EXPECT_FALSE(limiter.Accept(1'000'010'000));
  EXPECT_TRUE(limiter.Accept(5'000'000));
  EXPECT_FALSE(limiter.Accept(5'010'000));
  EXPECT_TRUE(limiter.Accept(9'000'000'000));
  EXPECT_FALSE(limiter.Accept(9'000'010'000));
}

}  // namespace
}  // namespace vantage
