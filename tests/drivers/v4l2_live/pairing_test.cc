// Depth of one node with the color of another.
#include <gtest/gtest.h>

#include <cstdlib>

#include "common/format.h"
#include "tests/drivers/v4l2_live/emulated_devices.h"
#include "tests/drivers/v4l2_live/live_camera.h"

namespace vantage {
namespace {

constexpr int64_t kPeriodUs = 10'000;

// Both nodes of one USB device.
std::string Node(int number, const std::string& fourcc, const std::string& more) {
  return Format("device %d\nserial D415\nport 1\nindex %d\nformat %s %dx%d 100\n%s\n",
                number,
                number,
                fourcc.c_str(),
                LiveCamera::kWidth,
                LiveCamera::kHeight,
                more.c_str());
}

std::string Both(const std::string& of_depth, const std::string& of_color) {
  return Node(0, "Z16", of_depth) + Node(1, "YUYV", of_color);
}

LiveCamera::Settings Paired() {
  LiveCamera::Settings settings;
  settings.device = "serial:D415";
  settings.stream.fps = 100;
  settings.stream.color = true;
  settings.v4l2.color_device = *DeviceSelector::Parse("path:/dev/video1");
  return settings;
}

class Pairing : public testing::Test {
 protected:
  void SetUp() override {
    live_.on_frame = [this](const CameraFrame& frame) {
      EXPECT_EQ(frame.depth_mm.size(), size_t{LiveCamera::kWidth} * LiveCamera::kHeight);
      if (!frame.color) return;
      ++num_pairs_;
      EXPECT_LE(std::abs(frame.color->utime - frame.utime), kPeriodUs / 2 + 1);
      EXPECT_EQ(frame.color->data.size(), size_t{3} * LiveCamera::kWidth * LiveCamera::kHeight);
    };
  }
  [[nodiscard]] bool GrabPairs(int count) {
    const int wanted = num_pairs_ + count;
    return live_.GrabUntil([&] { return num_pairs_ >= wanted; });
  }

  EmulatedDevices devices_;
  LiveCamera live_{Paired()};
  int num_pairs_ = 0;
};

TEST_F(Pairing, ColorIsThatOfTheSameTime) {
  devices_.Describe(Both("", ""));
  ASSERT_TRUE(GrabPairs(50)) << live_.Summary();
  EXPECT_EQ(live_.status().num_bad, 0);
  EXPECT_LE(std::abs(live_.status().color_delay_s), 0.51e-6 * kPeriodUs);
}

TEST_F(Pairing, StaleColorIsNeverShown) {
  devices_.Describe(Both("", "fault stamp -1000000"));
  ASSERT_TRUE(live_.GrabUntil([&] { return live_.status().num_unpaired >= 10; }))
      << live_.Summary();
  EXPECT_EQ(num_pairs_, 0);
  devices_.Describe(Both("", ""));
  EXPECT_TRUE(GrabPairs(10)) << live_.Summary();
  EXPECT_EQ(live_.status().num_reconnects, 0) << live_.Summary();
}

TEST_F(Pairing, BadColorIsLeftOut) {
  devices_.Describe(Both("", "fault error_flag every 2\nfault bytesused 7 every 3"));
  ASSERT_TRUE(live_.GrabUntil([&] { return live_.status().num_unpaired >= 10; }))
      << live_.Summary();
  EXPECT_TRUE(GrabPairs(10)) << live_.Summary();
}

TEST_F(Pairing, DepthGoesOnWhereColorStalls) {
  devices_.Describe(Both("", ""));
  ASSERT_TRUE(GrabPairs(5)) << live_.Summary();
  devices_.Describe(Both("", "fault stall"));
  ASSERT_TRUE(live_.GrabUntil([&] { return live_.status().num_unpaired >= 10; }))
      << live_.Summary();
  devices_.Describe(Both("", ""));
  EXPECT_TRUE(GrabPairs(10)) << live_.Summary();
}

TEST_F(Pairing, EitherThatIsUnpluggedEndsBothWhichComeBack) {
  devices_.Describe(Both("", ""));
  ASSERT_TRUE(GrabPairs(5)) << live_.Summary();
  for (const std::string& left : {Node(0, "Z16", ""), Node(1, "YUYV", "")}) {
    const int64_t reconnects = live_.status().num_reconnects;
    devices_.Describe(left);
    ASSERT_TRUE(live_.GrabUntilState(CameraState::kSearching)) << live_.Summary();
    devices_.Describe(Both("", ""));
    ASSERT_TRUE(GrabPairs(5)) << live_.Summary();
    EXPECT_EQ(live_.status().num_reconnects, reconnects + 1) << live_.Summary();
  }
  EXPECT_TRUE(live_.GrabUntilMessage("lacks the color of color_device path:/dev/video1"))
      << live_.Summary();
}

TEST_F(Pairing, SettingsAreThoseOfEither) {
  devices_.Describe(Both("control gain 0 9 1 1", "control brightness 0 9 1 1"));
  ASSERT_TRUE(GrabPairs(1)) << live_.Summary();
  EXPECT_TRUE(live_.camera().SetControl("gain", 5).ok());
  EXPECT_TRUE(live_.camera().SetControl("brightness", 6).ok());
  EXPECT_FALSE(live_.camera().SetControl("contrast", 6).ok());
  EXPECT_EQ(devices_.Control(0, "gain"), 5);
  EXPECT_EQ(devices_.Control(1, "brightness"), 6);
}

}  // namespace
}  // namespace vantage
