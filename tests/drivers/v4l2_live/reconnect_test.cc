// Which device is used, and that it is found again after it was unplugged.
#include <gtest/gtest.h>

#include "common/format.h"
#include "drivers/v4l2/v4l2_api.h"
#include "tests/drivers/v4l2_live/emulated_devices.h"
#include "tests/drivers/v4l2_live/live_camera.h"

namespace vantage {
namespace {

std::string Node(int number, const std::string& lines) {
  return Format("device %d\nspeed 10\n%s\n", number, lines.c_str());
}

std::string Serial(const std::string& serial) { return "serial " + serial + "\n"; }

// Grabs until the unplugged device is told to be lost.
void Unplug(const EmulatedDevices& devices, const std::string& others, LiveCamera* live) {
  devices.Describe(others);
  ASSERT_TRUE(live->GrabUntilState(CameraState::kLost)) << live->Summary();
  ASSERT_TRUE(live->GrabUntilState(CameraState::kSearching)) << live->Summary();
}

TEST(Reconnecting, FollowsTheSerialToAnotherNode) {
  const EmulatedDevices devices;
  const std::string other = Node(1, Serial("CAM1") + SmallFormat("YUYV"));
  devices.Describe(Node(0, Serial("CAM0") + SmallFormat("YUYV")) + other);
  LiveCamera::Settings settings;
  settings.device = "index:0";
  LiveCamera live(settings);
  ASSERT_TRUE(live.GrabFrames(5)) << live.Summary();
  EXPECT_EQ(live.status().serial, "CAM0");
  for (const int number : {5, 0, 12}) {
    SCOPED_TRACE(number);
    const int64_t reconnects = live.status().num_reconnects;
    Unplug(devices, other, &live);
    EXPECT_TRUE(live.GrabUntilMessage("no V4L2 device matches serial:CAM0")) << live.Summary();
    EXPECT_EQ(live.status().num_reconnects, reconnects);
    devices.Describe(Node(number, Serial("CAM0") + SmallFormat("YUYV")) + other);
    ASSERT_TRUE(live.GrabFrames(5)) << live.Summary();
    EXPECT_EQ(live.status().serial, "CAM0");
    EXPECT_EQ(live.status().num_reconnects, reconnects + 1);
  }
  EXPECT_EQ(live.status().num_bad, 0);
}

TEST(Reconnecting, AnotherDeviceAtItsNodeIsLeftAlone) {
  const EmulatedDevices devices;
  devices.Describe(DeviceZero(SmallFormat("YUYV")));
  LiveCamera live;
  ASSERT_TRUE(live.GrabFrames(5)) << live.Summary();
  Unplug(devices, Node(0, Serial("STRANGER") + SmallFormat("YUYV")), &live);
  const size_t before = live.num_frames();
  EXPECT_TRUE(live.GrabUntilMessage("(found: /dev/video0 (serial STRANGER))")) << live.Summary();
  EXPECT_EQ(live.status().state, CameraState::kSearching);
  EXPECT_EQ(live.num_frames(), before);
}

TEST(Reconnecting, ADeviceWithoutSerialComesBackAtItsNode) {
  const EmulatedDevices devices;
  const std::string camera = Node(3, SmallFormat("YUYV"));
  devices.Describe(camera);
  LiveCamera::Settings settings;
  settings.device = "path:/dev/video3";
  LiveCamera live(settings);
  ASSERT_TRUE(live.GrabFrames(5)) << live.Summary();
  EXPECT_EQ(live.status().serial, "/dev/video3");
  Unplug(devices, "", &live);
  devices.Describe(camera);
  EXPECT_TRUE(live.GrabFrames(5)) << live.Summary();
  EXPECT_EQ(live.status().num_reconnects, 1);
}

TEST(Reconnecting, AFormatThatIsGoneIsToldUntilItIsBack) {
  const EmulatedDevices devices;
  devices.Describe(DeviceZero(SmallFormat("YUYV")));
  LiveCamera live;
  ASSERT_TRUE(live.GrabFrames(5)) << live.Summary();
  Unplug(devices, "", &live);
  devices.Describe(DeviceZero("format YUYV 32x24 30"));
  EXPECT_TRUE(live.GrabUntilMessage("YUYV (32x24 at 30 Hz)")) << live.Summary();
  EXPECT_EQ(live.status().num_reconnects, 0);
  devices.Describe(DeviceZero(SmallFormat("YUYV")));
  EXPECT_TRUE(live.GrabFrames(5)) << live.Summary();
  EXPECT_EQ(live.status().num_reconnects, 1);
}

TEST(Reconnecting, AnotherFormatOfTheSameSizeWillDo) {
  const EmulatedDevices devices;
  devices.Describe(DeviceZero(SmallFormat("YUYV")));
  LiveCamera live;
  ASSERT_TRUE(live.GrabFrames(5)) << live.Summary();
  Unplug(devices, "", &live);
  devices.Describe(DeviceZero(SmallFormat("MJPG") + "padding 16"));
  ASSERT_TRUE(live.GrabFrames(5)) << live.Summary();
  EXPECT_EQ(live.frame().color->data.size(), size_t{3} * LiveCamera::kWidth * LiveCamera::kHeight);
  Unplug(devices, "", &live);
  devices.Describe(DeviceZero(SmallFormat("Z16")));
  ASSERT_TRUE(live.GrabFrames(5)) << live.Summary();
  EXPECT_FALSE(live.frame().depth_mm.empty());
  EXPECT_EQ(live.status().num_bad, 0);
}

TEST(Reconnecting, RestartOpensTheSameDeviceAgain) {
  const EmulatedDevices devices;
  devices.Describe(DeviceZero(SmallFormat("YUYV")));
  LiveCamera live;
  ASSERT_TRUE(live.GrabFrames(5)) << live.Summary();
  live.camera().Restart();
  ASSERT_TRUE(live.GrabFrames(5)) << live.Summary();
  EXPECT_EQ(live.status().num_reconnects, 1);
}

// Two cameras; each name is that of the second one.
class Selectors : public testing::TestWithParam<std::string> {};

TEST_P(Selectors, ChooseTheDevice) {
  const EmulatedDevices devices;
  devices.Describe(Node(0, "card Left Eye\n" + Serial("CAM0") + SmallFormat("YUYV")) +
                   Node(4, "card Right Eye\nport 6\n" + Serial("CAM4") + SmallFormat("YUYV")));
  LiveCamera::Settings settings;
  settings.device = GetParam();
  LiveCamera live(settings);
  ASSERT_TRUE(live.GrabFrames(3)) << live.Summary();
  EXPECT_EQ(live.status().serial, "CAM4");
}

INSTANTIATE_TEST_SUITE_P(All,
                         Selectors,
                         testing::Values("index:1",
                                         "serial:CAM4",
                                         "path:/dev/video4",
                                         "uri:/dev/video4",
                                         "id:usb-Emulated_Right_Eye_CAM4-video-index0",
                                         "path:/dev/v4l/by-id/"
                                         "usb-Emulated_Right_Eye_CAM4-video-index0",
                                         "path:/dev/v4l/by-path/"
                                         "pci-0000:00:14.0-usb-0:7:1.0-video-index0",
                                         "bus:usb-0000:00:14.0-7"));

// As RealSense cameras are: color, metadata and depth are nodes of one USB device.
TEST(SeveralNodes, TheDepthIsFoundByTheSerial) {
  const EmulatedDevices devices;
  const std::string color = "serial D415\nport 1\n" + SmallFormat("YUYV");
  const std::string depth = "serial D415\nport 1\nindex 2\n" + SmallFormat("Z16");
  devices.Describe(Node(0, color) + Node(1, "kind metadata\nserial D415\nport 1\nindex 1\n") +
                   Node(2, depth));
  LiveCamera::Settings settings;
  settings.device = "serial:D415";
  LiveCamera live(settings);
  ASSERT_TRUE(live.GrabFrames(3)) << live.Summary();
  EXPECT_FALSE(live.frame().depth_mm.empty());

  settings.v4l2.pixel_format = "YUYV";
  LiveCamera other(settings);
  ASSERT_TRUE(other.GrabFrames(3)) << other.Summary();
  EXPECT_TRUE(other.frame().color.has_value());
  EXPECT_TRUE(live.GrabFrames(3)) << live.Summary();
  EXPECT_EQ(live.status().num_reconnects, 0);
}

// As of cheap cameras, which all have the same serial: each is only its node.
TEST(SeveralDevices, ASharedSerialIsNone) {
  const EmulatedDevices devices;
  devices.Describe(Node(0, Serial("0001") + SmallFormat("YUYV")) +
                   Node(2, Serial("0001") + SmallFormat("GREY")));
  LiveCamera::Settings settings;
  settings.device = "path:/dev/video2";
  LiveCamera live(settings);
  ASSERT_TRUE(live.GrabFrames(3)) << live.Summary();
  EXPECT_EQ(live.status().serial, "/dev/video2");
}

}  // namespace
}  // namespace vantage
