// Cameras whose depth and color are nodes of their own, as a RealSense's.
#include <gtest/gtest.h>

#include <set>

#include "common/format.h"
#include "tests/drivers/v4l2_live/emulated_devices.h"
#include "tests/drivers/v4l2_live/live_camera.h"

namespace vantage {
namespace {

// A node of the USB device at port 7.
std::string Node(int number, int index, const std::string& lines) {
  return Format(
      "device %d\nspeed 4\nserial RS\nport 7\nindex %d\n%s\n", number, index, lines.c_str());
}

std::string Depth(int number, const std::string& lines = "") {
  return Node(number, 0, SmallFormat("Z16") + lines);
}
std::string Color(int number, const std::string& lines = "") {
  return Node(number, 2, SmallFormat("YUYV") + lines);
}
std::string Metadata(int number) { return Node(number, 1, "kind metadata"); }

LiveCamera::Settings Of(const std::string& device) {
  LiveCamera::Settings settings;
  settings.device = device;
  return settings;
}

LiveCamera::Settings Paired(const std::string& color_device) {
  LiveCamera::Settings settings = Of("serial:RS");
  settings.stream.color = true;
  settings.v4l2.color_device = DeviceSelector::Parse(color_device).value();
  return settings;
}

TEST(SeveralNodes, ColorThatWasChosenComesBackAsColor) {
  const EmulatedDevices devices;
  devices.Describe(Depth(0) + Metadata(1) + Color(2));
  LiveCamera live(Of("path:/dev/video2"));
  ASSERT_TRUE(live.GrabFrames(3)) << live.Summary();
  EXPECT_TRUE(live.frame().color.has_value());
  devices.Describe("");
  ASSERT_TRUE(live.GrabUntilState(CameraState::kLost)) << live.Summary();
  devices.Describe(Depth(4) + Metadata(5) + Color(6));
  ASSERT_TRUE(live.GrabUntil([&] { return live.status().num_reconnects == 1; }));
  ASSERT_TRUE(live.GrabFrames(3)) << live.Summary();
  EXPECT_TRUE(live.frame().color.has_value()) << "not the depth of the same serial";
  EXPECT_TRUE(live.frame().depth_mm.empty());
}

TEST(SeveralNodes, BusyDepthIsNotReplacedByColor) {
  const EmulatedDevices devices;
  devices.Describe(Depth(0, "fail S_FMT EBUSY") + Color(2));
  LiveCamera live(Of("serial:RS"));
  EXPECT_TRUE(live.GrabUntilMessage("another program streams from it")) << live.Summary();
  EXPECT_EQ(live.status().num_captured, 0);
  devices.Describe(Depth(0) + Color(2));
  ASSERT_TRUE(live.GrabFrames(3)) << live.Summary();
  EXPECT_FALSE(live.frame().depth_mm.empty());
}

TEST(SeveralNodes, AFormatFindsItsNode) {
  const EmulatedDevices devices;
  devices.Describe(Depth(0) + Color(2));
  LiveCamera::Settings settings = Of("serial:RS");
  settings.v4l2.pixel_format = "YUYV";
  LiveCamera live(settings);
  ASSERT_TRUE(live.GrabFrames(3)) << live.Summary();
  EXPECT_TRUE(live.frame().color.has_value());
}

TEST(PairedColor, ComesWithDepthOfTheSameTimeAndNeverTwice) {
  const EmulatedDevices devices;
  devices.Describe(Depth(0) + Metadata(1) + Color(2));
  LiveCamera live(Paired("serial:RS"));
  std::set<int64_t> color_times;
  int num_pairs = 0;
  constexpr int64_t kHalfPeriodUs = 16'667;
  live.on_frame = [&](const CameraFrame& frame) {
    ASSERT_FALSE(frame.depth_mm.empty());
    if (!frame.color) return;
    ++num_pairs;
    EXPECT_LE(std::abs(frame.color->utime - frame.utime), kHalfPeriodUs);
    EXPECT_TRUE(color_times.insert(frame.color->utime - frame.utime + frame.device_time_us).second);
    EXPECT_EQ(frame.color->data.size(), 3U * LiveCamera::kWidth * LiveCamera::kHeight);
  };
  ASSERT_TRUE(live.GrabFrames(60)) << live.Summary();
  EXPECT_GT(num_pairs, 20);
  EXPECT_EQ(live.status().num_bad, 0);
}

TEST(PairedColor, BadColorLeavesDepthAlone) {
  const EmulatedDevices devices;
  devices.Describe(Depth(0) + Color(2, "fault error_flag every 2"));
  LiveCamera live(Paired("path:/dev/video2"));
  ASSERT_TRUE(live.GrabFrames(40)) << live.Summary();
  EXPECT_EQ(live.status().num_bad, 0);
  EXPECT_GT(live.status().num_unpaired, 0);
  EXPECT_EQ(live.status().num_reconnects, 0);
}

TEST(PairedColor, ThatStallsLeavesDepthAlone) {
  const EmulatedDevices devices;
  devices.Describe(Depth(0) + Color(2, "fault stall after 5"));
  LiveCamera live(Paired("serial:RS"));
  ASSERT_TRUE(live.GrabFrames(60)) << live.Summary();
  EXPECT_GE(live.status().num_unpaired, 30);
  EXPECT_EQ(live.status().num_reconnects, 0);
}

TEST(PairedColor, ThatIsLackingIsToldUntilItComes) {
  const EmulatedDevices devices;
  devices.Describe(Depth(0));
  LiveCamera live(Paired("serial:RS"));
  EXPECT_TRUE(live.GrabUntilMessage(
      "device /dev/video0 lacks the color of color_device serial:RS: no other device matches it"))
      << live.Summary();
  devices.Describe(Depth(0) + Color(2));
  ASSERT_TRUE(live.GrabUntil([&] { return live.frame().color.has_value(); })) << live.Summary();
}

TEST(PairedColor, UnpluggedComesBackWithItsDepth) {
  const EmulatedDevices devices;
  devices.Describe(Depth(0) + Color(2));
  LiveCamera live(Paired("serial:RS"));
  ASSERT_TRUE(live.GrabFrames(5)) << live.Summary();
  devices.Describe(Depth(0));
  ASSERT_TRUE(live.GrabUntilState(CameraState::kLost)) << live.Summary();
  devices.Describe(Depth(0) + Color(8));
  ASSERT_TRUE(live.GrabUntil([&] { return live.status().num_reconnects == 1; })) << live.Summary();
  int num_pairs = 0;
  live.on_frame = [&](const CameraFrame& frame) { num_pairs += frame.color ? 1 : 0; };
  EXPECT_TRUE(live.GrabUntil([&] { return num_pairs >= 5; })) << live.Summary();
}

}  // namespace
}  // namespace vantage
