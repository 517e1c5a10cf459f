// The real vantage-v4l2 on the kernel's vivid devices, in the guest of tools/test --kernel.
#include <gtest/gtest.h>
#include <linux/videodev2.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "bus/image_conversion.h"
#include "common/format.h"
#include "common/statistics.h"
#include "tests/kernel/camera_listener.h"
#include "tests/kernel/driver_process.h"
#include "tests/kernel/vivid_device.h"

namespace vantage {
namespace {

using std::chrono::milliseconds;

constexpr const char* kDevice = "/dev/video0";
// Modes of vivid's webcam that an emulated processor keeps up with.
struct Mode {
  int width = 320;   // px
  int height = 180;  // px
  int fps = 10;      // Hz
};
constexpr Mode kSmall;
constexpr Mode kVga = {640, 480, 5};

// One camera's table; `more` are further lines.
std::string Config(const std::string& camera,
                   const std::string& device,
                   const std::string& more,
                   const Mode& mode = kSmall) {
  return Format(
      "[camera.%s]\ndriver = \"v4l2\"\ndevice = \"%s\"\nwidth_px = %d\nheight_px = %d\nfps = "
      "%d\nrate_hz = 0.0\n%s\n",
      camera.c_str(),
      device.c_str(),
      mode.width,
      mode.height,
      mode.fps,
      more.c_str());
}

class VividCamera : public ::testing::Test {
 protected:
  void SetUp() override { vivid_->Reset(); }

  // Starts the driver on the first device and waits for its images.
  void Stream(const std::string& more, const Mode& mode = kSmall) {
    driver_ = std::make_unique<DriverProcess>(
        Config("VIVID", std::string("path:") + kDevice, more, mode));
    ASSERT_TRUE(listener_.ListenForImages(5)) << Report();
    ASSERT_TRUE(listener_.ListenForState(camera_status_v2_t::STREAMING)) << Report();
  }
  [[nodiscard]] std::string Report() const {
    return listener_.Summary() + "\n" + (driver_ ? driver_->Output() : "");
  }
  // Images come again, of a device that came back.
  void ExpectRecovery(int64_t reconnects_before) {
    EXPECT_TRUE(listener_.ListenUntil([&] {
      return listener_.status().state == camera_status_v2_t::STREAMING &&
             listener_.status().num_reconnects > reconnects_before;
    })) << Report();
    EXPECT_TRUE(listener_.ListenForImages(10)) << Report();
  }

  std::unique_ptr<VividDevice> vivid_ = std::make_unique<VividDevice>(kDevice);
  CameraListener listener_{"VIVID"};
  std::unique_ptr<DriverProcess> driver_;
};

// Mean red, green and blue of 8 x 8 px in the middle of each of vivid's color bars, left to right.
std::array<std::array<double, 3>, 8> BarColors(const image_t& image) {
  std::array<std::array<double, 3>, 8> colors{};
  for (int bar = 0; bar < 8; ++bar) {
    for (int i = 0; i < 64; ++i) {
      const int u = image.width * (2 * bar + 1) / 16 + i % 8 - 4;
      const int v = image.height / 2 + i / 8;
      for (int channel = 0; channel < 3; ++channel) {
        colors[static_cast<size_t>(bar)][static_cast<size_t>(channel)] +=
            image.data.at(static_cast<size_t>(v * image.row_stride + 3 * u + channel)) / 64.0;
      }
    }
  }
  return colors;
}

// White, yellow, cyan, green, magenta, red, blue, black: green falls with the second half, red with
// every other pair, blue with every other bar.
void ExpectColorBars(const image_t& image) {
  ASSERT_EQ(image.pixelformat, image_t::PIXEL_FORMAT_RGB);
  const auto colors = BarColors(image);
  constexpr double kOn = 191.0;  // 75 %
  for (size_t bar = 0; bar < 8; ++bar) {
    const std::array<double, 3> expected = {
        (bar & 2U) == 0 ? kOn : 0.0, (bar & 4U) == 0 ? kOn : 0.0, (bar & 1U) == 0 ? kOn : 0.0};
    for (size_t channel = 0; channel < 3; ++channel) {
      EXPECT_NEAR(colors[bar][channel], expected[channel], 12.0)
          << "bar " << bar << ", " << channel;
    }
  }
}

// Ten frames: none lost, at the device's pace, stamped shortly before they came.
void ExpectSteadyStream(CameraListener& listener, const Mode& mode = kSmall) {
  constexpr size_t kNumFrames = 10;
  const size_t first = listener.arrivals().size();
  ASSERT_TRUE(listener.ListenForImages(kNumFrames)) << listener.Summary();
  EXPECT_EQ(listener.NumLost(), 0) << listener.Summary();
  EXPECT_EQ(listener.status().num_bad, 0) << listener.Summary();
  EXPECT_EQ(listener.images().images.at(0).width, mode.width);
  EXPECT_EQ(listener.images().images.at(0).height, mode.height);
  const auto& arrivals = listener.arrivals();
  std::vector<double> periods;
  for (size_t i = first; i < arrivals.size(); ++i) {
    EXPECT_LE(arrivals[i].utime, arrivals[i].receive_utime);
    EXPECT_LT(arrivals[i].receive_utime - arrivals[i].utime, 1'000'000);
    periods.push_back(1e-6 * static_cast<double>(arrivals[i].utime - arrivals[i - 1].utime));
    EXPECT_GT(periods.back(), 0.0);
  }
  const double period = Median(periods);
  EXPECT_NEAR(period, 1.0 / mode.fps, 0.25 / mode.fps) << "s";
  std::printf("     %.1f Hz, %zu images, none lost\n", 1.0 / period, arrivals.size());
}

class VividColor : public VividCamera, public ::testing::WithParamInterface<std::string> {};

TEST_P(VividColor, ShowsTheColorBarsWithoutLoss) {
  Stream(Format("pixel_format = \"%s\"", GetParam().c_str()));
  ExpectSteadyStream(listener_);
  ExpectColorBars(listener_.images().images.at(0));
  EXPECT_EQ(driver_->Stop(), 0) << Report();
}

INSTANTIATE_TEST_SUITE_P(Formats,
                         VividColor,
                         ::testing::Values("YUYV", "UYVY", "GRBG", "RGB3", "BGR3"),
                         [](const auto& test) { return test.param; });

// vivid's picture stands still: what is read from it beside the driver is what the driver shows.
TEST_F(VividCamera, GreyIsShownAsItIs) {
  const std::vector<uint8_t> expected =
      VividDevice(kDevice).ReadFrame(V4L2_PIX_FMT_GREY, kVga.width, kVga.height);
  Stream("pixel_format = \"GREY\"\ncolor_encoding = \"gray\"", kVga);
  ExpectSteadyStream(listener_, kVga);
  const image_t& image = listener_.images().images.at(0);
  EXPECT_EQ(image.pixelformat, image_t::PIXEL_FORMAT_GRAY);
  EXPECT_TRUE(image.data == expected) << "of " << image.data.size() << " bytes";
}

TEST_F(VividCamera, Y16IsDepthInMillimetres) {
  const std::vector<uint8_t> expected =
      VividDevice(kDevice).ReadFrame(V4L2_PIX_FMT_Y16, kVga.width, kVga.height);
  Stream("pixel_format = \"Y16\"", kVga);
  ExpectSteadyStream(listener_, kVga);
  const Result<DepthFrame> frame = DepthFrameFromMessage(listener_.images());
  ASSERT_TRUE(frame.ok()) << frame.error().message;
  ASSERT_EQ(2 * frame->image.depth.size(), expected.size());
  for (size_t i = 0; i < frame->image.depth.size(); ++i) {
    const int millimetres = expected[2 * i] | expected[2 * i + 1] << 8;
    const float depth = frame->image.depth[i];
    ASSERT_EQ(std::isnan(depth) ? 0L : std::lround(1e3 * static_cast<double>(depth)), millimetres)
        << "pixel " << i;
  }
}

TEST_F(VividCamera, ControlsAreSetAndSetAgainAfterReconnecting) {
  Stream("pixel_format = \"YUYV\"\n[camera.VIVID.controls]\nbrightness = 77\n");
  EXPECT_EQ(vivid_->Get("Brightness"), 77);
  listener_.SendControl("contrast", 99);
  EXPECT_TRUE(listener_.ListenUntil([&] { return vivid_->Get("Contrast") == 99; })) << Report();
  listener_.SendControl("warp_factor", 9);
  EXPECT_TRUE(listener_.ListenForMessage("warp_factor")) << Report();

  vivid_->Reset();
  const int64_t reconnects = listener_.status().num_reconnects;
  vivid_->Set("Inject Fatal Streaming Error", 1);
  ExpectRecovery(reconnects);
  EXPECT_EQ(vivid_->Get("Brightness"), 77);
  EXPECT_EQ(vivid_->Get("Contrast"), 99);
}

TEST_F(VividCamera, FrameWithErrorFlagIsDroppedAndCounted) {
  Stream("pixel_format = \"YUYV\"");
  for (int i = 0; i < 3; ++i) {
    vivid_->Set("Inject V4L2_BUF_FLAG_ERROR", 1);
    listener_.ListenFor(milliseconds(200));
  }
  EXPECT_TRUE(listener_.ListenUntil([&] { return listener_.status().num_bad == 3; })) << Report();
  EXPECT_EQ(listener_.status().state, camera_status_v2_t::STREAMING);
  EXPECT_EQ(listener_.status().num_reconnects, 0);
}

TEST_F(VividCamera, FramesThatTheDeviceDropsAreCountedAsMissed) {
  vivid_->Set("Percentage of Dropped Buffers", 40);
  Stream("pixel_format = \"YUYV\"");
  EXPECT_TRUE(listener_.ListenForImages(20)) << Report();
  EXPECT_TRUE(listener_.ListenUntil([&] { return listener_.status().num_missed >= 5; }))
      << Report();
  EXPECT_EQ(listener_.NumLost(), 0) << Report();
}

// vivid's count begins 128 frames before it wraps around.
TEST_F(VividCamera, FrameCountThatWrapsAroundIsNoLoss) {
  vivid_->Set("Wrap Sequence Number", 1);
  Stream("pixel_format = \"YUYV\"", {320, 180, 30});
  ASSERT_TRUE(listener_.ListenForImages(140)) << Report();
  EXPECT_EQ(listener_.NumLost(), 0) << Report();
  EXPECT_GE(listener_.status().num_missed, 0) << Report();
  EXPECT_LT(listener_.status().num_missed, 1000) << Report();
}

TEST_F(VividCamera, StampsOfAnotherClockBecomeTheHostsTime) {
  constexpr int kNear32Bits = 2;  // s: stamps begin 16 s before 2^31 s
  vivid_->Set("Wrap Timestamp", kNear32Bits);
  Stream("pixel_format = \"YUYV\"");
  ExpectSteadyStream(listener_);
}

TEST_F(VividCamera, BusyDeviceIsToldAndTakenOnceItIsFree) {
  auto other = std::make_unique<VividDevice>(kDevice);
  other->TakeStream();
  driver_ = std::make_unique<DriverProcess>(
      Config("VIVID", std::string("path:") + kDevice, "pixel_format = \"YUYV\""));
  EXPECT_TRUE(listener_.ListenForMessage("busy")) << Report();
  EXPECT_NE(listener_.status().state, camera_status_v2_t::STREAMING);
  other.reset();
  EXPECT_TRUE(listener_.ListenForImages(10)) << Report();
}

// What fails once and works the next time.
class VividRefusal : public VividCamera, public ::testing::WithParamInterface<std::string> {};

TEST_P(VividRefusal, IsSurvived) {
  Stream("pixel_format = \"YUYV\"");
  vivid_->Set(Format("Inject VIDIOC_%s Error", GetParam().c_str()), 1);
  const int64_t captured = listener_.status().num_captured;
  listener_.SendRestart();
  EXPECT_TRUE(listener_.ListenUntil([&] {
    return listener_.status().state == camera_status_v2_t::STREAMING &&
           listener_.status().num_captured > captured + 5;
  })) << Report();
}

INSTANTIATE_TEST_SUITE_P(Calls,
                         VividRefusal,
                         ::testing::Values("REQBUFS", "QBUF", "STREAMON"),
                         [](const auto& test) { return test.param; });

// The node stays but answers nothing until everybody has closed it.
TEST_F(VividCamera, ComesBackAfterDisconnecting) {
  Stream("pixel_format = \"YUYV\"");
  const int64_t reconnects = listener_.status().num_reconnects;
  vivid_->Set("Disconnect", 1);
  vivid_.reset();
  ExpectRecovery(reconnects);
}

// As unplugging does: the node goes, and one of the same bus comes.
TEST_F(VividCamera, ComesBackAfterItsDriverWasTakenAway) {
  const std::string bus = vivid_->bus();
  vivid_.reset();
  driver_ =
      std::make_unique<DriverProcess>(Config("VIVID", "bus:" + bus, "pixel_format = \"YUYV\""));
  ASSERT_TRUE(listener_.ListenForImages(5)) << Report();
  const int64_t reconnects = listener_.status().num_reconnects;
  UnbindVivid();
  EXPECT_TRUE(listener_.ListenForState(camera_status_v2_t::SEARCHING)) << Report();
  BindVivid();
  ExpectRecovery(reconnects);
}

TEST_F(VividCamera, TwoAtOnce) {
  CameraListener second_listener("SECOND");
  DriverProcess second(Config("SECOND", "path:/dev/video1", "pixel_format = \"YUYV\""));
  Stream("pixel_format = \"YUYV\"");
  ASSERT_TRUE(second_listener.ListenForImages(10)) << second.Output();
  ASSERT_TRUE(listener_.ListenForImages(10)) << Report();
  EXPECT_EQ(listener_.NumLost(), 0) << Report();
  EXPECT_EQ(second_listener.NumLost(), 0) << second_listener.Summary();
}

TEST_F(VividCamera, FormatThatItLacksIsAnsweredWithThoseItHas) {
  driver_ = std::make_unique<DriverProcess>(
      Config("VIVID", std::string("path:") + kDevice, "pixel_format = \"Z16\""));
  EXPECT_TRUE(listener_.ListenForMessage("Y16")) << Report();
  EXPECT_NE(listener_.status().state, camera_status_v2_t::STREAMING);
}

TEST_F(VividCamera, DeviceThatIsNoCameraIsSaidToBeNone) {
  driver_ =
      std::make_unique<DriverProcess>(Config("VIVID", "path:/dev/null", "pixel_format = \"YUYV\""));
  EXPECT_TRUE(listener_.ListenForMessage("/dev/null")) << Report();
  EXPECT_TRUE(driver_->IsRunning()) << Report();
}

}  // namespace
}  // namespace vantage
