// The real vantage-v4l2 on the kernel's vivid devices, in the guest of tools/test --kernel.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "bus/image_conversion.h"
#include "common/format.h"
#include "tests/kernel/camera_listener.h"
#include "tests/kernel/driver_process.h"
#include "tests/kernel/vivid_device.h"

namespace vantage {
namespace {

using std::chrono::milliseconds;

constexpr const char* kDevice = "/dev/video0";
struct Mode {
  int width = 640;   // px
  int height = 480;  // px
  int fps = 25;      // Hz; the most that vivid's webcam has at this size
};
constexpr Mode kVga;

// One camera's table; `more` are further lines.
std::string Config(const std::string& camera,
                   const std::string& device,
                   const std::string& more,
                   const Mode& mode = kVga) {
  return Format(
      "[camera.%s]\ndevice = \"%s\"\nwidth_px = %d\nheight_px = %d\nfps = %d\nrate_hz = 0.0\n%s\n",
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
  void Stream(const std::string& more, const Mode& mode = kVga) {
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

// The middles of vivid's eight color bars from left to right, averaged over a few pixels.
std::array<std::array<double, 3>, 8> BarColors(const image_t& image, int channels) {
  std::array<std::array<double, 3>, 8> colors{};
  constexpr int kSide = 8;
  for (int bar = 0; bar < 8; ++bar) {
    for (int channel = 0; channel < channels; ++channel) {
      double sum = 0.0;
      for (int v = 0; v < kSide; ++v) {
        for (int u = 0; u < kSide; ++u) {
          const int column = image.width * (2 * bar + 1) / 16 + u - kSide / 2;
          const int row = image.height / 2 + v;
          sum += image.data.at(
              static_cast<size_t>(row * image.row_stride + channels * column + channel));
        }
      }
      colors[static_cast<size_t>(bar)][static_cast<size_t>(channel)] = sum / (kSide * kSide);
    }
  }
  return colors;
}

// White, yellow, cyan, green, magenta, red, blue, black: green falls with the second half, red with
// every other pair, blue with every other bar.
void ExpectColorBars(const image_t& image) {
  ASSERT_EQ(image.pixelformat, image_t::PIXEL_FORMAT_RGB);
  ASSERT_EQ(image.width, kVga.width);
  ASSERT_EQ(image.height, kVga.height);
  const auto colors = BarColors(image, 3);
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

// A second of frames: none lost, at the device's pace, stamped shortly before they came.
void ExpectSteadyStream(CameraListener& listener) {
  const size_t first = listener.arrivals().size();
  ASSERT_TRUE(listener.ListenForImages(kVga.fps + 1)) << listener.Summary();
  EXPECT_EQ(listener.NumLost(), 0) << listener.Summary();
  EXPECT_EQ(listener.status().num_bad, 0) << listener.Summary();
  const auto& arrivals = listener.arrivals();
  std::vector<int64_t> periods;
  for (size_t i = first + 1; i < arrivals.size(); ++i) {
    EXPECT_GT(arrivals[i].utime, arrivals[i - 1].utime);
    EXPECT_LE(arrivals[i].utime, arrivals[i].receive_utime);
    EXPECT_LT(arrivals[i].receive_utime - arrivals[i].utime, 1'000'000);
    periods.push_back(arrivals[i].utime - arrivals[i - 1].utime);
  }
  std::ranges::nth_element(periods, periods.begin() + kVga.fps / 2);
  EXPECT_NEAR(static_cast<double>(periods[kVga.fps / 2]), 1e6 / kVga.fps, 4e3)
      << "us, median period";
}

class VividColor : public VividCamera, public ::testing::WithParamInterface<std::string> {};

TEST_P(VividColor, ShowsTheColorBarsWithoutLoss) {
  Stream(Format("format = \"%s\"", GetParam().c_str()));
  ExpectSteadyStream(listener_);
  ExpectColorBars(listener_.images().images.at(0));
  EXPECT_EQ(driver_->Stop(), 0) << Report();
}

INSTANTIATE_TEST_SUITE_P(Formats,
                         VividColor,
                         ::testing::Values("YUYV", "UYVY", "GRBG"),
                         [](const auto& test) { return test.param; });

TEST_F(VividCamera, GreyBarsGetDarkerWithoutLoss) {
  Stream("format = \"GREY\"");
  ExpectSteadyStream(listener_);
  const image_t& image = listener_.images().images.at(0);
  ASSERT_EQ(image.pixelformat, image_t::PIXEL_FORMAT_GRAY);
  ASSERT_EQ(image.data.size(), static_cast<size_t>(kVga.width * kVga.height));
  const auto colors = BarColors(image, 1);
  for (size_t bar = 1; bar < 8; ++bar) EXPECT_LT(colors[bar][0] + 5.0, colors[bar - 1][0]);
}

TEST_F(VividCamera, Y16IsDepthOfThatManyMillimetresWithoutLoss) {
  Stream("format = \"Y16\"");
  ExpectSteadyStream(listener_);
  const Result<DepthFrame> frame = DepthFrameFromMessage(listener_.images());
  ASSERT_TRUE(frame.ok()) << frame.error().message;
  ASSERT_EQ(frame->image.width, kVga.width);
  ASSERT_EQ(frame->image.height, kVga.height);
  // Gray values of 8 bits, in both bytes: multiples of 257.
  double before = 65.536;
  for (int bar = 0; bar < 7; ++bar) {
    const double depth = frame->image.at(kVga.width * (2 * bar + 1) / 16, kVga.height / 2);
    EXPECT_LT(depth, before) << "m, bar " << bar;
    EXPECT_NEAR(std::remainder(1e3 * depth, 257.0), 0.0, 1.0) << "mm, bar " << bar;
    before = depth;
  }
}

TEST_F(VividCamera, ControlsAreSetAndSetAgainAfterReconnecting) {
  Stream("format = \"YUYV\"\n[camera.VIVID.controls]\nbrightness = 77\n");
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
  Stream("format = \"YUYV\"");
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
  Stream("format = \"YUYV\"");
  EXPECT_TRUE(listener_.ListenForImages(20)) << Report();
  EXPECT_TRUE(listener_.ListenUntil([&] { return listener_.status().num_missed >= 5; }))
      << Report();
  EXPECT_EQ(listener_.NumLost(), 0) << Report();
}

// vivid's count begins 128 frames before it wraps around.
TEST_F(VividCamera, FrameCountThatWrapsAroundIsNoLoss) {
  vivid_->Set("Wrap Sequence Number", 1);
  Stream("format = \"YUYV\"", {320, 180, 60});
  ASSERT_TRUE(listener_.ListenForImages(140)) << Report();
  EXPECT_EQ(listener_.NumLost(), 0) << Report();
  EXPECT_LT(listener_.status().num_missed, 20) << Report();
}

TEST_F(VividCamera, StampsOfAnotherClockBecomeTheHostsTime) {
  constexpr int kNear32Bits = 2;  // s: stamps begin 16 s before 2^31 s
  vivid_->Set("Wrap Timestamp", kNear32Bits);
  Stream("format = \"YUYV\"");
  ExpectSteadyStream(listener_);
}

TEST_F(VividCamera, BusyDeviceIsToldAndTakenOnceItIsFree) {
  auto other = std::make_unique<VividDevice>(kDevice);
  other->TakeStream();
  driver_ = std::make_unique<DriverProcess>(
      Config("VIVID", std::string("path:") + kDevice, "format = \"YUYV\""));
  EXPECT_TRUE(listener_.ListenForMessage("busy")) << Report();
  EXPECT_NE(listener_.status().state, camera_status_v2_t::STREAMING);
  other.reset();
  EXPECT_TRUE(listener_.ListenForImages(10)) << Report();
}

// What fails once and works the next time.
class VividRefusal : public VividCamera, public ::testing::WithParamInterface<std::string> {};

TEST_P(VividRefusal, IsSurvived) {
  Stream("format = \"YUYV\"");
  vivid_->Set(Format("Inject VIDIOC_%s Error", GetParam().c_str()), 1);
  const int64_t captured = listener_.status().num_captured;
  listener_.SendRestart();
  EXPECT_TRUE(listener_.ListenUntil([&] {
    return listener_.status().state == camera_status_v2_t::STREAMING &&
           listener_.status().num_captured > captured + kVga.fps;
  })) << Report();
}

INSTANTIATE_TEST_SUITE_P(Calls,
                         VividRefusal,
                         ::testing::Values("REQBUFS", "QBUF", "STREAMON"),
                         [](const auto& test) { return test.param; });

// The node stays but answers nothing until everybody has closed it.
TEST_F(VividCamera, ComesBackAfterDisconnecting) {
  Stream("format = \"YUYV\"");
  const int64_t reconnects = listener_.status().num_reconnects;
  vivid_->Set("Disconnect", 1);
  vivid_.reset();
  ExpectRecovery(reconnects);
}

// As unplugging does: the node goes, and one of the same bus comes.
TEST_F(VividCamera, ComesBackAfterItsDriverWasTakenAway) {
  const std::string bus = vivid_->bus();
  vivid_.reset();
  driver_ = std::make_unique<DriverProcess>(Config("VIVID", "bus:" + bus, "format = \"YUYV\""));
  ASSERT_TRUE(listener_.ListenForImages(5)) << Report();
  const int64_t reconnects = listener_.status().num_reconnects;
  UnbindVivid();
  EXPECT_TRUE(listener_.ListenForState(camera_status_v2_t::SEARCHING)) << Report();
  BindVivid();
  ExpectRecovery(reconnects);
}

TEST_F(VividCamera, TwoAtOnce) {
  CameraListener second_listener("SECOND");
  DriverProcess second(Config("SECOND", "path:/dev/video1", "format = \"YUYV\""));
  Stream("format = \"YUYV\"");
  ASSERT_TRUE(second_listener.ListenForImages(kVga.fps)) << second.Output();
  ASSERT_TRUE(listener_.ListenForImages(kVga.fps)) << Report();
  EXPECT_EQ(listener_.NumLost(), 0) << Report();
  EXPECT_EQ(second_listener.NumLost(), 0) << second_listener.Summary();
}

TEST_F(VividCamera, FormatThatItLacksIsAnsweredWithThoseItHas) {
  driver_ = std::make_unique<DriverProcess>(
      Config("VIVID", std::string("path:") + kDevice, "format = \"Z16\""));
  EXPECT_TRUE(listener_.ListenForMessage("Y16")) << Report();
  EXPECT_NE(listener_.status().state, camera_status_v2_t::STREAMING);
}

TEST_F(VividCamera, DeviceThatIsNoCameraIsSaidToBeNone) {
  driver_ = std::make_unique<DriverProcess>(Config("VIVID", "path:/dev/null", "format = \"YUYV\""));
  EXPECT_TRUE(listener_.ListenForMessage("/dev/null")) << Report();
  EXPECT_TRUE(driver_->IsRunning()) << Report();
}

}  // namespace
}  // namespace vantage
