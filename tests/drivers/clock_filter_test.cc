#include "drivers/clock/clock_filter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/rng.h"

namespace vantage {
namespace {

constexpr int64_t kEpoch = 1'700'000'000'000'000;  // us
constexpr int64_t kPeriod = 33'333;                // us
constexpr double kBaseLatency = 4000.0;            // us

// A device that measures every kPeriod of true time, and a host that hears of it late.
class SimulatedCamera {
 public:
  struct Sample {
    int64_t device_us;
    int64_t arrival_us;
    int64_t exposure_us;  // Truth, on the host's clock as it stands at arrival.
  };

  explicit SimulatedCamera(uint64_t seed) : rng_(seed) {}

  double drift_ppm = 0.0;       // Of the device's clock.
  int64_t host_step_us = 0;     // Added to the host's clock.
  int64_t device_start_us = 0;  // Subtracted from the device's clock.
  int64_t modulus_us = 0;       // 0: none
  double stall_chance = 0.004;  // For each frame, of 100 ms in which nothing gets through.
  double jitter_us = 2000.0;    // Mean of the exponential part of the latency.

  Sample Next() {
    const int64_t now = kPeriod * count_++;
    const double latency = kBaseLatency - jitter_us * std::log(1.0 - rng_.Uniform());
    double arrival = static_cast<double>(now) + latency;
    if (rng_.Uniform() < stall_chance) blocked_until_ = arrival + 100'000.0;
    arrival = std::max({arrival, blocked_until_, last_arrival_});
    last_arrival_ = arrival;
    device_exact_ += static_cast<double>(kPeriod) * (1.0 + 1e-6 * drift_ppm);
    int64_t device = static_cast<int64_t>(device_exact_) - device_start_us;
    if (modulus_us > 0) device %= modulus_us;
    return {
        device, kEpoch + static_cast<int64_t>(arrival) + host_step_us, kEpoch + now + host_step_us};
  }
  [[nodiscard]] int64_t device_now() const { return static_cast<int64_t>(device_exact_); }

 private:
  Rng rng_;
  int64_t count_ = 0;
  double device_exact_ = 5e6;
  double blocked_until_ = 0.0;
  double last_arrival_ = 0.0;
};

struct Errors {
  double lowest = 1e18;    // us, result minus true exposure
  double highest = -1e18;  // us
};

// Feeds `seconds` of frames; checks what must always hold and returns the errors' range.
Errors Feed(SimulatedCamera& camera, ClockFilter& filter, double seconds, bool monotonic = true) {
  Errors errors;
  int64_t last = 0;
  for (int i = 0; i < static_cast<int>(seconds * 1e6 / kPeriod); ++i) {
    const SimulatedCamera::Sample sample = camera.Next();
    const int64_t result = filter.Update(sample.device_us, sample.arrival_us);
    EXPECT_LE(result, sample.arrival_us);
    if (monotonic) {
      EXPECT_GT(result, last) << "frame " << i;
    }
    last = result;
    const double error = static_cast<double>(result - sample.exposure_us);
    errors.lowest = std::min(errors.lowest, error);
    errors.highest = std::max(errors.highest, error);
  }
  return errors;
}

// After the first seconds a result is late by the least latency, and by no more than 1 ms besides.
void ExpectSettled(const Errors& errors) {
  EXPECT_GT(errors.lowest, kBaseLatency - 1000.0);
  EXPECT_LT(errors.highest, kBaseLatency + 1000.0);
}

TEST(ClockFilter, FirstResultIsTheArrival) {
  ClockFilter filter;
  EXPECT_EQ(filter.Update(17, kEpoch), kEpoch);
  EXPECT_EQ(filter.offset_us(), static_cast<double>(kEpoch - 17));
  EXPECT_EQ(filter.skew_ppm(), 0.0);
}

TEST(ClockFilter, ParametersOutOfRangeAreNamed) {
  ClockFilter::Parameters parameters;
  parameters.window_us = 10;
  const Result<void> valid = parameters.Validate();
  ASSERT_FALSE(valid.ok());
  EXPECT_NE(valid.error().message.find("window_us = 10"), std::string::npos);
}

TEST(ClockFilter, ExactClocksWithoutJitterGiveTheLeastLatency) {
  SimulatedCamera camera(1);
  camera.jitter_us = 0.0;
  camera.stall_chance = 0.0;
  ClockFilter filter;
  const Errors errors = Feed(camera, filter, 30.0);
  EXPECT_NEAR(errors.lowest, kBaseLatency, 2.0);
  EXPECT_NEAR(errors.highest, kBaseLatency, 2.0);
  EXPECT_NEAR(filter.skew_ppm(), 0.0, 0.2);
}

TEST(ClockFilter, FollowsDriftThroughJitterAndStalls) {
  for (const double drift : {-200.0, -50.0, 0.0, 50.0, 200.0}) {
    for (uint64_t seed = 1; seed <= 5; ++seed) {
      SimulatedCamera camera(seed);
      camera.drift_ppm = drift;
      ClockFilter filter;
      Feed(camera, filter, 10.0);
      ExpectSettled(Feed(camera, filter, 120.0));
      EXPECT_NEAR(filter.skew_ppm(), -drift, 20.0);
      EXPECT_EQ(filter.num_steps(), 0);
    }
  }
}

TEST(ClockFilter, ReestimatesADriftThatChanges) {
  SimulatedCamera camera(3);
  camera.drift_ppm = 20.0;
  ClockFilter filter;
  Feed(camera, filter, 60.0);
  camera.drift_ppm = 60.0;
  Feed(camera, filter, 60.0);
  ExpectSettled(Feed(camera, filter, 10.0));
  EXPECT_NEAR(filter.skew_ppm(), -60.0, 20.0);
}

TEST(ClockFilter, StallAtTheStartIsForgotten) {
  ClockFilter filter;
  // The first frame waited 90 ms and the next ones come in a bunch.
  for (int64_t i = 0; i < 100; ++i) {
    const int64_t exposure = kEpoch + kPeriod * i;
    const int64_t arrival = std::max(exposure + 4000, kEpoch + 90'000);
    const int64_t result = filter.Update(kPeriod * i, arrival);
    EXPECT_LE(result, arrival);
    if (i > 6) {
      EXPECT_EQ(result, exposure + 4000) << i;
    }
  }
  EXPECT_EQ(filter.num_steps(), 0);
}

TEST(ClockFilter, HostClockSteps) {
  for (const int64_t step : {-3'600'000'000LL, -300'000LL, 60'000LL, 300'000LL, 3'600'000'000LL}) {
    SimulatedCamera camera(7);
    camera.drift_ppm = 80.0;
    ClockFilter filter;
    Feed(camera, filter, 30.0);
    camera.host_step_us = step;
    // Forwards it takes half a second to tell a step from a stall, and never lies later than now.
    Feed(camera, filter, 11.0, /*monotonic=*/false);
    EXPECT_EQ(filter.num_steps(), 1) << step;
    ExpectSettled(Feed(camera, filter, 60.0));
    EXPECT_EQ(filter.num_steps(), 1) << step;
  }
}

TEST(ClockFilter, BackwardHostStepIsSeenAtOnce) {
  SimulatedCamera camera(8);
  camera.stall_chance = 0.0;
  ClockFilter filter;
  Feed(camera, filter, 30.0);
  camera.host_step_us = -500'000;
  const SimulatedCamera::Sample sample = camera.Next();
  EXPECT_EQ(filter.Update(sample.device_us, sample.arrival_us), sample.arrival_us);
  EXPECT_EQ(filter.num_steps(), 1);
}

TEST(ClockFilter, SmallHostStepErrsByNoMoreThanItself) {
  for (const int64_t step : {-15'000LL, 15'000LL}) {
    SimulatedCamera camera(9);
    ClockFilter filter;
    Feed(camera, filter, 60.0);
    camera.host_step_us = step;
    const Errors errors = Feed(camera, filter, 60.0);
    EXPECT_GT(errors.lowest, kBaseLatency - 16'000.0);
    EXPECT_LT(errors.highest, kBaseLatency + 16'000.0);
    ExpectSettled(Feed(camera, filter, 30.0));
  }
}

TEST(ClockFilter, DeviceClockStartsAnew) {
  SimulatedCamera camera(11);
  ClockFilter filter;
  Feed(camera, filter, 30.0);
  camera.device_start_us = camera.device_now();
  Feed(camera, filter, 10.0);
  EXPECT_EQ(filter.num_steps(), 1);
  ExpectSettled(Feed(camera, filter, 30.0));
}

TEST(ClockFilter, DeviceClockWrapsAround) {
  // 2^32 us would take 72 minutes to come round; the sample starts shortly before.
  for (const int64_t modulus : {int64_t{1} << 32, int64_t{60'000'000}}) {
    SimulatedCamera camera(12);
    camera.modulus_us = modulus;
    camera.device_start_us = -(modulus - 20'000'000);
    camera.drift_ppm = 100.0;
    ClockFilter::Parameters parameters;
    // 32 bits is what is expected of a device.
    if (modulus != int64_t{1} << 32) parameters.device_modulus_us = modulus;
    ClockFilter filter(parameters);
    Feed(camera, filter, 10.0);
    ExpectSettled(Feed(camera, filter, 200.0));
    EXPECT_EQ(filter.num_steps(), 0);
  }
}

TEST(ClockFilter, DeviceClockStartsAnewInsideItsRange) {
  SimulatedCamera camera(13);
  camera.modulus_us = int64_t{1} << 32;
  ClockFilter filter;
  camera.device_start_us = -3'000'000'000;
  Feed(camera, filter, 10.0);
  camera.device_start_us = camera.device_now();
  Feed(camera, filter, 10.0);
  EXPECT_EQ(filter.num_steps(), 1);
  ExpectSettled(Feed(camera, filter, 30.0));
}

TEST(ClockFilter, LongSilenceStartsAnew) {
  ClockFilter filter;
  filter.Update(0, kEpoch);
  filter.Update(kPeriod, kEpoch + kPeriod);
  const int64_t later = kEpoch + 600'000'000;
  EXPECT_EQ(filter.Update(500'000'000, later), later);
  EXPECT_EQ(filter.num_steps(), 1);
}

TEST(ClockFilter, ResetForgets) {
  SimulatedCamera camera(14);
  camera.drift_ppm = 200.0;
  ClockFilter filter;
  Feed(camera, filter, 30.0);
  filter.Reset(0);
  EXPECT_EQ(filter.skew_ppm(), 0.0);
  EXPECT_EQ(filter.Update(0, 1000), 1000);
  EXPECT_EQ(filter.num_steps(), 0);
}

}  // namespace
}  // namespace vantage
