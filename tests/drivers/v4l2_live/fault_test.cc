// What goes wrong while a device streams.
#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>
#include <vector>

#include "tests/drivers/v4l2_live/emulated_devices.h"
#include "tests/drivers/v4l2_live/live_camera.h"

namespace vantage {
namespace {

std::string Small(const std::string& fourcc, const std::string& more) {
  return DeviceZero(SmallFormat(fourcc) + more);
}

struct BadFrame {
  std::string name;
  std::string fourcc;
  std::string fault;
  std::string sentence;  // Part of it.
};
void PrintTo(const BadFrame& each, std::ostream* out) { *out << each.name; }

class BadFrames : public testing::TestWithParam<BadFrame> {};

TEST_P(BadFrames, AreCountedAndToldAndTheOthersCome) {
  const EmulatedDevices devices;
  devices.Describe(Small(GetParam().fourcc, GetParam().fault + " every 3"));
  LiveCamera live;
  ASSERT_TRUE(live.GrabUntil([&] { return live.status().num_bad >= 6 && live.num_frames() >= 6; }))
      << live.Summary();
  EXPECT_TRUE(live.GrabUntilMessage(GetParam().sentence)) << live.Summary();
  EXPECT_EQ(live.status().num_captured,
            live.status().num_bad + static_cast<int64_t>(live.num_frames()));
  EXPECT_FALSE(live.HasBeen(CameraState::kLost)) << live.Summary();
  EXPECT_EQ(live.status().num_reconnects, 0) << live.Summary();
  devices.Describe(Small(GetParam().fourcc, ""));
  // Those that were filled before.
  ASSERT_TRUE(live.GrabFrames(20));
  const int64_t num_bad = live.status().num_bad;
  ASSERT_TRUE(live.GrabFrames(6)) << live.Summary();
  EXPECT_EQ(live.status().num_bad, num_bad) << live.Summary();
}

INSTANTIATE_TEST_SUITE_P(
    All,
    BadFrames,
    testing::Values(
        BadFrame{"MarkedAsDamaged", "YUYV", "fault error_flag", "marked the image as damaged"},
        BadFrame{"Short", "YUYV", "fault bytesused 6143", "a short image of 6143 bytes"},
        BadFrame{"Empty", "YUYV", "fault bytesused 0", "a short image of 0 bytes"},
        BadFrame{"ShortDepth", "Z16", "fault bytesused 100", "a short image of 100 bytes"},
        BadFrame{"BeyondItsBuffer", "YUYV", "fault bytesused 6145", "of a buffer of 6144"},
        BadFrame{"FarBeyondItsBuffer", "GREY", "fault bytesused 0xffffffff", "of a buffer of 3072"},
        BadFrame{"StampOfThePast", "YUYV", "fault stamp -4000000000000000", "the time stamp"},
        BadFrame{"TruncatedJpeg", "MJPG", "fault bytesused 700", "JPEG"},
        BadFrame{"EmptyJpeg", "MJPG", "fault bytesused 0", "JPEG"},
        BadFrame{"CorruptJpeg", "MJPG", "fault corrupt 2", "JPEG"},
        BadFrame{"JpegBeyondItsBuffer", "MJPG", "fault bytesused 0x7fffffff", "of a buffer of"}),
    [](const auto& each) { return each.param.name; });

// Whatever a decoder makes of it: no crash, and every frame is counted.
TEST(CorruptJpeg, AnywhereIsNoCrash) {
  const EmulatedDevices devices;
  devices.Describe(Small("MJPG", ""));
  LiveCamera live;
  ASSERT_TRUE(live.GrabFrames(1));
  for (int first = 2; first < 1200; first += 23) {
    devices.Describe(Small("MJPG", "fault corrupt " + std::to_string(first)));
    const int64_t captured = live.status().num_captured;
    ASSERT_TRUE(live.GrabUntil([&] { return live.status().num_captured >= captured + 4; }))
        << live.Summary();
  }
  devices.Describe(Small("MJPG", ""));
  EXPECT_TRUE(live.GrabFrames(20)) << live.Summary();
  EXPECT_EQ(live.status().num_captured,
            live.status().num_bad + static_cast<int64_t>(live.num_frames()));
}

TEST(LostFrames, AreCounted) {
  const EmulatedDevices devices;
  devices.Describe(Small("YUYV", "fault drop every 4"));
  LiveCamera live;
  ASSERT_TRUE(live.GrabUntil([&] { return live.status().num_missed >= 5; })) << live.Summary();
  EXPECT_EQ(live.status().num_bad, 0);
  EXPECT_GE(live.status().num_captured, 12);
}

TEST(LostFrames, AGapIsAsLongAsTheDeviceSays) {
  const EmulatedDevices devices;
  devices.Describe(Small("YUYV", "fault sequence 1000000 after 20"));
  LiveCamera live;
  ASSERT_TRUE(live.GrabUntil([&] { return live.status().num_missed > 0; }));
  ASSERT_TRUE(live.GrabUntil([&] { return live.status().num_missed >= 1000000; }));
  EXPECT_LT(live.status().num_missed, 1010000);
}

TEST(LostFrames, ADeviceThatCountsAnewHasLostNothing) {
  const EmulatedDevices devices;
  devices.Describe(Small("YUYV", "fault sequence -20 after 20"));
  LiveCamera live;
  ASSERT_TRUE(live.GrabFrames(40));
  EXPECT_LT(live.status().num_missed, 10000);
  EXPECT_EQ(live.status().num_bad, 0);
}

// After each of these the device is opened anew, and streams when the fault is gone.
struct Break {
  std::string name;
  std::string fault;
  std::string sentence;
};
void PrintTo(const Break& each, std::ostream* out) { *out << each.name; }

class Breaks : public testing::TestWithParam<Break> {};

TEST_P(Breaks, EndTheStreamWhichComesBackByItself) {
  const EmulatedDevices devices;
  devices.Describe(Small("YUYV", ""));
  LiveCamera live;
  ASSERT_TRUE(live.GrabFrames(5)) << live.Summary();
  devices.Describe(Small("YUYV", GetParam().fault));
  ASSERT_TRUE(live.GrabUntil([&] { return live.HasBeen(CameraState::kLost); })) << live.Summary();
  EXPECT_TRUE(live.GrabUntilMessage(GetParam().sentence)) << live.Summary();
  devices.Describe(Small("YUYV", ""));
  ASSERT_TRUE(live.GrabUntil([&] {
    return live.status().num_reconnects > 0 && live.status().state == CameraState::kStreaming;
  })) << live.Summary();
  EXPECT_TRUE(live.GrabFrames(5)) << live.Summary();
  EXPECT_EQ(live.status().serial, "CAM0");
}

INSTANTIATE_TEST_SUITE_P(
    All,
    Breaks,
    testing::Values(
        Break{"Unplugged", "fail DQBUF ENODEV\nfail OPEN ENODEV", "device CAM0 was unplugged"},
        Break{"EveryCallFails", "fail DQBUF EIO", "failed to deliver an image"},
        Break{"PollTellsOfAnError", "fault poll_error", "device CAM0 was unplugged"},
        Break{"PollHangsUp", "fault poll_hangup", "device CAM0 was unplugged"},
        Break{"TakesNoBufferBack", "fail QBUF ENODEV", "device CAM0 was unplugged"}),
    [](const auto& each) { return each.param.name; });

TEST(Stall, IsToldAndEndsWithTheNextFrame) {
  const EmulatedDevices devices;
  devices.Describe(Small("YUYV", ""));
  LiveCamera live;
  ASSERT_TRUE(live.GrabFrames(5)) << live.Summary();
  devices.Describe(Small("YUYV", "fault stall"));
  ASSERT_TRUE(live.GrabUntilState(CameraState::kStalled)) << live.Summary();
  EXPECT_TRUE(live.GrabUntilMessage("device CAM0 gives no frame for")) << live.Summary();
  devices.Describe(Small("YUYV", ""));
  EXPECT_TRUE(live.GrabFrames(5)) << live.Summary();
  EXPECT_EQ(live.status().state, CameraState::kStreaming);
}

TEST(Stall, ThatLastsHasTheDeviceOpenedAnew) {
  const EmulatedDevices devices;
  devices.Describe(Small("YUYV", "fault stall after 20"));  // Of every stream.
  LiveCamera live;
  ASSERT_TRUE(live.GrabUntil([&] { return live.status().num_reconnects >= 2; })) << live.Summary();
  EXPECT_TRUE(live.GrabUntilMessage("opening it anew")) << live.Summary();
  EXPECT_GE(live.num_frames(), 21U);
  EXPECT_LT(live.status().num_missed, 20);  // Some on a busy machine; none for counting anew.
}

TEST(IoError, OnceIsOneBadFrame) {
  const EmulatedDevices devices;
  devices.Describe(Small("YUYV", ""));
  LiveCamera live;
  ASSERT_TRUE(live.GrabFrames(5)) << live.Summary();
  devices.Describe(Small("YUYV", "fail DQBUF EIO 1"));
  EXPECT_TRUE(live.GrabUntilMessage("failed to deliver an image")) << live.Summary();
  EXPECT_TRUE(live.GrabFrames(5)) << live.Summary();
  EXPECT_EQ(live.status().num_bad, 1) << live.Summary();
  EXPECT_EQ(live.status().num_reconnects, 0) << live.Summary();
}

}  // namespace
}  // namespace vantage
