// What becomes of a device's stamps: utime stays near the time of arrival, and never goes back
// unless a clock did.
#include <gtest/gtest.h>

#include <chrono>
#include <ostream>
#include <vector>

#include "tests/drivers/v4l2_live/emulated_devices.h"
#include "tests/drivers/v4l2_live/live_camera.h"

namespace vantage {
namespace {

// us; far less than the jumps here, and more than what a busy machine holds a frame back.
constexpr int64_t kNear = 10'000'000;

int64_t NowUtime() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

struct Stamps {
  std::string name;
  std::string fault;
  size_t num_frames = 100;  // The filter believes a step after half a second: 150.
};
void PrintTo(const Stamps& each, std::ostream* out) { *out << each.name; }

class Clock : public testing::TestWithParam<Stamps> {};

TEST_P(Clock, UtimeIsOrderedAndNearTheTruth) {
  const EmulatedDevices devices;
  devices.Describe(DeviceZero(SmallFormat("YUYV") + GetParam().fault));
  LiveCamera live;
  int64_t last_utime = 0;
  live.on_frame = [&](const CameraFrame& frame) {
    const int64_t now = NowUtime();
    EXPECT_LE(frame.utime, now);
    EXPECT_GT(frame.utime, now - kNear);
    EXPECT_GE(frame.utime, last_utime) << "frame " << live.num_frames();
    last_utime = frame.utime;
  };
  ASSERT_TRUE(live.GrabFrames(GetParam().num_frames)) << live.Summary();
  EXPECT_EQ(live.status().num_bad, 0) << live.Summary();
  EXPECT_EQ(live.status().num_reconnects, 0) << live.Summary();
}

INSTANTIATE_TEST_SUITE_P(All,
                         Clock,
                         testing::Values(Stamps{"Good", ""},
                                         Stamps{"OneFarAhead", "fault stamp 60000000 at 60"},
                                         Stamps{"OneFarBehind", "fault stamp -60000000 at 60"},
                                         Stamps{"OftenFarAhead", "fault stamp 60000000 every 7"},
                                         Stamps{"OftenFarBehind", "fault stamp -60000000 every 7"},
                                         Stamps{"JumpAhead", "fault stamp 60000000 after 60", 250},
                                         Stamps{"JumpBack", "fault stamp -60000000 after 60", 250},
                                         Stamps{"StandStill", "fault stamp_still after 60", 250},
                                         Stamps{"AlwaysTheSame", "fault stamp_still"}),
                         [](const auto& each) { return each.param.name; });

// Of good stamps the distances are kept, whenever the frames arrive.
TEST(GoodStamps, KeepTheirDistances) {
  const EmulatedDevices devices;
  devices.Describe(DeviceZero(SmallFormat("YUYV")));
  LiveCamera live;
  std::vector<CameraFrame> frames;
  live.on_frame = [&](const CameraFrame& frame) { frames.push_back(frame); };
  ASSERT_TRUE(live.GrabFrames(100)) << live.Summary();
  constexpr int64_t kPeriodUs = 3333;  // 300 Hz
  int num_alike = 0;
  for (size_t i = 51; i < frames.size(); ++i) {
    const int64_t device_us = frames[i].device_time_us - frames[i - 1].device_time_us;
    EXPECT_GE(device_us, kPeriodUs);
    EXPECT_NEAR(static_cast<double>((device_us + 500) % kPeriodUs), 500.0, 499.0);
    if (std::abs(frames[i].utime - frames[i - 1].utime - device_us) < 1000) ++num_alike;
  }
  EXPECT_GT(num_alike, 24);  // More than half.
}

}  // namespace
}  // namespace vantage
