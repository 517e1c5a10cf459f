// Devices that can't be used, or not as asked: one sentence, no crash, and frames as soon as the
// device is as it should be.
#include <gtest/gtest.h>

#include <ostream>

#include "tests/drivers/v4l2_live/emulated_devices.h"
#include "tests/drivers/v4l2_live/live_camera.h"

namespace vantage {
namespace {

struct Refusal {
  std::string name;
  std::string description;
  std::string sentence;  // Part of it.
  std::string device = "path:/dev/video0";
};
void PrintTo(const Refusal& each, std::ostream* out) { *out << each.name; }

std::string Yuyv(const std::string& more) { return DeviceZero(SmallFormat("YUYV") + more); }

class Refusals : public testing::TestWithParam<Refusal> {};

TEST_P(Refusals, SayWhyAndEndWithTheCause) {
  const Refusal& param = GetParam();
  const EmulatedDevices devices;
  devices.Describe(param.description);
  LiveCamera::Settings settings;
  settings.device = param.device;
  LiveCamera live(settings);
  EXPECT_TRUE(live.GrabUntilMessage(param.sentence)) << live.Summary();
  EXPECT_EQ(live.num_frames(), 0U);
  EXPECT_FALSE(live.HasBeen(CameraState::kStreaming)) << live.Summary();
  devices.Describe(Yuyv(""));
  EXPECT_TRUE(live.GrabFrames(3)) << live.Summary();
  EXPECT_EQ(live.status().num_bad, 0);
}

INSTANTIATE_TEST_SUITE_P(
    NoCamera,
    Refusals,
    testing::Values(
        Refusal{"Nothing", "", "no V4L2 device matches path:/dev/video0 (found: none)"},
        Refusal{"RegularFile", "device 0\nkind file\n", "is no character device"},
        Refusal{"OtherDevice", "device 0\nkind null\n", "has the major number 1, expected 81"},
        Refusal{"OutputOnly", "device 0\nkind output\n", "does: video output"},
        Refusal{"Metadata", "device 0\nkind metadata\n", "does: metadata capture"},
        Refusal{"NoV4l2", Yuyv("fail QUERYCAP ENOTTY"), "is no V4L2 device"},
        Refusal{"OtherSerial",
                "device 0\nserial OTHER\n" + SmallFormat("YUYV"),
                "no V4L2 device matches serial:CAM0 (found: /dev/video0 (serial OTHER))",
                "serial:CAM0"}),
    [](const auto& each) { return each.param.name; });

INSTANTIATE_TEST_SUITE_P(
    NotAllowed,
    Refusals,
    testing::Values(
        Refusal{"NoPermission", Yuyv("fail OPEN EACCES"), "it belongs to the group video"},
        Refusal{"GoneBeforeOpening", Yuyv("fail OPEN ENODEV"), "it was unplugged"},
        Refusal{"BusyFormat", Yuyv("fail S_FMT EBUSY"), "another program streams from it"},
        Refusal{"BusyBuffers", Yuyv("fail REQBUFS EBUSY"), "another program streams from it"},
        Refusal{"NoBandwidth", Yuyv("fail STREAMON ENOSPC"), "its USB bus has no bandwidth left"},
        Refusal{"StreamProtocol", Yuyv("fail STREAMON EPROTO"), "does not start to stream"},
        Refusal{"NoMapping", Yuyv("fail MMAP ENOMEM"), "can't map its buffers: Cannot allocate"},
        Refusal{"NoQueueing", Yuyv("fail QBUF EIO"), "takes no buffer"},
        Refusal{"NoBufferQuery", Yuyv("fail QUERYBUF EINVAL"), "does not describe its buffers"}),
    [](const auto& each) { return each.param.name; });

INSTANTIATE_TEST_SUITE_P(
    Formats,
    Refusals,
    testing::Values(
        Refusal{"NoFormats", "device 0\nserial CAM0\n", "none"},
        Refusal{"UnknownFormat", DeviceZero("format H264 64x48 30"), "not known here"},
        Refusal{
            "OtherSize", DeviceZero("format YUYV 640x480 30 15"), "YUYV (640x480 at 30, 15 Hz)"},
        Refusal{"OtherRate", DeviceZero("format YUYV 64x48 15"), "YUYV (64x48 at 15 Hz)"},
        Refusal{"NoSize", DeviceZero("format YUYV 0x0 30"), "YUYV (0x0"},
        Refusal{"AbsurdSize", DeviceZero("format YUYV 4294967295x4294967295 30"), "YUYV ("},
        Refusal{"GivesOtherWidth", Yuyv("override width 32"), "gives YUYV of 32x48 px when asked"},
        Refusal{"GivesNoHeight", Yuyv("override height 0"), "gives YUYV of 64x0 px"},
        Refusal{"GivesHugeWidth", Yuyv("override width 0x7fffffff"), "gives YUYV of 2147483647x48"},
        Refusal{"GivesOtherFormat", Yuyv("override pixelformat MJPG"), "gives MJPG of 64x48 px"},
        Refusal{"RowsTooShort", Yuyv("override bytesperline 64"), "rows are 64 bytes apart"},
        Refusal{"RowsHuge", Yuyv("override bytesperline 0x7fffffff"), "says that an image takes"},
        Refusal{"ImageOfNothing", Yuyv("override sizeimage 0"), "an image takes 0 bytes"},
        Refusal{"ImageHuge", Yuyv("override sizeimage 0x7fffffff"), "takes 2147483647 bytes"},
        Refusal{"JpegOfNothing",
                DeviceZero(SmallFormat("MJPG") + "override sizeimage 0"),
                "an image takes 0 bytes"}),
    [](const auto& each) { return each.param.name; });

INSTANTIATE_TEST_SUITE_P(
    Buffers,
    Refusals,
    testing::Values(
        Refusal{"None", Yuyv("override buffer_count 0"), "gives 0 buffers"},
        Refusal{"One", Yuyv("override buffer_count 1"), "gives 1 buffers"},
        Refusal{"Huge", Yuyv("override buffer_count 0x7fffffff"), "gives 2147483647 buffers"},
        Refusal{"OfNothing", Yuyv("override buffer_length 0"), "buffers of 0 bytes"},
        Refusal{"TooShort", Yuyv("override buffer_length 100"), "buffers of 100 bytes"},
        Refusal{"TooLong", Yuyv("override buffer_length 0x7fffffff"), "of 2147483647 bytes"}),
    [](const auto& each) { return each.param.name; });

// What is odd and yet no reason to refuse a device.
class Oddities : public testing::TestWithParam<std::pair<std::string, std::string>> {};

TEST_P(Oddities, GiveFrames) {
  const EmulatedDevices devices;
  devices.Describe(Yuyv("control brightness 0 255 1 128\n" + GetParam().second));
  LiveCamera live;
  EXPECT_TRUE(live.GrabFrames(5)) << live.Summary();
  EXPECT_EQ(live.status().num_bad, 0) << live.Summary();
}

INSTANTIATE_TEST_SUITE_P(
    All,
    Oddities,
    testing::Values(std::pair("EndlessLists", "fault endless"),
                    std::pair("UnterminatedWords", "fault unterminated"),
                    std::pair("NoRateToSet", "fail S_PARM ENOTTY"),
                    std::pair("RateOfNothing", "override interval_numerator 0"),
                    std::pair("RateWithoutEnd", "override interval_denominator 0"),
                    std::pair("NoRowLength", "override bytesperline 0"),
                    std::pair("NoSizesListed", "fail ENUM_FRAMESIZES ENOTTY"),
                    std::pair("NoRatesListed", "fail ENUM_FRAMEINTERVALS ENOTTY"),
                    std::pair("NoControls", "fail QUERY_EXT_CTRL ENOTTY"),
                    std::pair("ManyBuffers", "override buffer_count 32"),
                    std::pair("FractionOfARate", "format YUYV 64x48 30000/1001")),
    [](const auto& each) { return std::string(each.param.first); });

TEST(StepwiseSizes, AnyOfThemWillDo) {
  const EmulatedDevices devices;
  devices.Describe(DeviceZero("stepwise YUYV 16x16 1920x1088 16 30"));
  LiveCamera live;
  EXPECT_TRUE(live.GrabFrames(5)) << live.Summary();
  devices.Describe(DeviceZero("stepwise YUYV 16x16 1920x1088 20 30"));
  live.camera().Restart();
  EXPECT_TRUE(live.GrabUntilMessage("16-1920x16-1088")) << live.Summary();
}

// Files of the system, which nobody emulates.
TEST(NoDevice, OfTheSystemIsTakenForACamera) {
  const EmulatedDevices devices;
  const std::pair<const char*, const char*> files[] = {
      {"path:/dev/null", "has the major number 1, expected 81"},
      {"path:/proc/self/status", "is no character device"},
      {"path:/", "is no character device"},
      {"path:/nowhere/at/all", "matches path:/nowhere/at/all (found: none)"},
  };
  for (const auto& [device, sentence] : files) {
    LiveCamera::Settings settings;
    settings.device = device;
    LiveCamera live(settings);
    EXPECT_TRUE(live.GrabUntilMessage(sentence)) << device << "\n" << live.Summary();
    EXPECT_EQ(live.status().state, CameraState::kSearching);
  }
}

// Another program, in its own words, that streams from /dev/video0.
TEST(SecondOpener, IsToldAndStreamsWhenTheFirstIsDone) {
  const EmulatedDevices devices;
  devices.Describe(Yuyv(""));
  auto first = std::make_unique<LiveCamera>();
  ASSERT_TRUE(first->GrabFrames(3)) << first->Summary();
  LiveCamera second;
  EXPECT_TRUE(second.GrabUntilMessage("another program streams from it")) << second.Summary();
  EXPECT_EQ(second.num_frames(), 0U);
  // It does not disturb the first one.
  EXPECT_TRUE(first->GrabFrames(3)) << first->Summary();
  EXPECT_EQ(first->status().num_reconnects, 0);
  EXPECT_EQ(first->status().num_bad, 0);
  first.reset();
  EXPECT_TRUE(second.GrabFrames(3)) << second.Summary();
}

}  // namespace
}  // namespace vantage
