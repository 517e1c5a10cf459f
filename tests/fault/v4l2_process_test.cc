// The real vantage-v4l2 on emulated devices: v4l2_process.sh runs this in a network of its own.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "bus/image_conversion.h"
#include "common/format.h"
#include "common/rng.h"
#include "tests/drivers/v4l2_live/emulated_devices.h"
#include "tests/drivers/v4l2_shim/test_scene.h"
#include "tests/kernel/camera_listener.h"
#include "tests/kernel/driver_process.h"

namespace vantage {
namespace {

constexpr int kWidth = 64;   // px
constexpr int kHeight = 48;  // px

std::string Node(int number, const std::string& lines) {
  return Format(
      "device %d\nserial CAM0\nspeed 4\nformat YUYV %dx%d 30\nformat Z16 %dx%d 30\n"
      "format MJPG %dx%d 30\n%s\n",
      number,
      kWidth,
      kHeight,
      kWidth,
      kHeight,
      kWidth,
      kHeight,
      lines.c_str());
}

std::string Config(const std::string& camera, const std::string& more) {
  return Format(
      "[camera.%s]\ndriver = \"v4l2\"\ndevice = \"serial:CAM0\"\nwidth_px = %d\n"
      "height_px = %d\nfps = 30\nrate_hz = 0.0\nstall_timeout_s = 0.3\n%s\n",
      camera.c_str(),
      kWidth,
      kHeight,
      more.c_str());
}

// Processes that are started from now on have the shim.
void PreloadShim() { setenv("LD_PRELOAD", VANTAGE_SHIM_LIBRARY, 1); }

// What the program prints on its console.
std::string RunList() {
  const std::string program =
      std::filesystem::read_symlink("/proc/self/exe").parent_path() / "vantage-v4l2";
  PreloadShim();
  FILE* pipe = popen((program + " --list 2>&1").c_str(), "r");
  std::string text;
  std::array<char, 4096> buffer;
  while (const size_t size = fread(buffer.data(), 1, buffer.size(), pipe)) {
    text.append(buffer.data(), size);
  }
  text += Format("exit code %d", WEXITSTATUS(pclose(pipe)));
  return text;
}

class V4l2Process : public testing::Test {
 protected:
  void Start(const std::string& more) {
    PreloadShim();
    driver_ = std::make_unique<DriverProcess>(Config("CAM", more));
  }
  // Listens until the condition holds; minutes are a bound against hanging, not an expectation.
  [[nodiscard]] bool Until(const std::function<bool()>& condition) {
    for (int i = 0; i < 12; ++i) {
      if (listener_.ListenUntil(condition)) return true;
    }
    return false;
  }
  [[nodiscard]] bool UntilImages(size_t count) {
    const size_t wanted = listener_.arrivals().size() + count;
    return Until([&] { return listener_.arrivals().size() >= wanted; });
  }
  [[nodiscard]] bool UntilState(int8_t state) {
    return Until([&] { return Status().state == state; });
  }
  [[nodiscard]] bool UntilMessage(const std::string& text) {
    return Until([&] { return Status().message.find(text) != std::string::npos; });
  }
  [[nodiscard]] const camera_status_v2_t& Status() const { return listener_.status(); }
  [[nodiscard]] std::string Report() const {
    return listener_.Summary() + "\n" + (driver_ ? driver_->Output() : "");
  }

  EmulatedDevices devices_;
  CameraListener listener_{"CAM"};
  std::unique_ptr<DriverProcess> driver_;
};

TEST_F(V4l2Process, ControlsOfTheConfigAndOfCommandsOutliveUnplugging) {
  const std::string controls =
      "control brightness 0 255 1 128\ncontrol contrast 0 95 1 32\n"
      "control auto_exposure 0 3 1 3\ncontrol exposure_time_absolute 3 2047 1 250\n";
  devices_.Describe(Node(0, controls));
  Start(
      "[camera.CAM.controls]\nbrightness = 77\nauto_exposure = 1\nexposure_time_absolute = 100\n");
  ASSERT_TRUE(UntilImages(5)) << Report();
  EXPECT_TRUE(Until([&] { return devices_.Control(0, "exposure_time_absolute") == 100; }));
  EXPECT_EQ(devices_.Control(0, "brightness"), 77);
  listener_.SendControl("contrast", 90);
  EXPECT_TRUE(Until([&] { return devices_.Control(0, "contrast") == 90; })) << Report();
  listener_.SendControl("warp_factor", 9);
  EXPECT_TRUE(UntilMessage("has no control warp_factor")) << Report();

  devices_.Describe("");
  ASSERT_TRUE(UntilMessage("no V4L2 device matches serial:CAM0")) << Report();
  EXPECT_EQ(Status().state, camera_status_v2_t::SEARCHING);
  devices_.Describe(Node(3, controls));
  ASSERT_TRUE(UntilImages(5)) << Report();
  EXPECT_TRUE(Until([&] { return devices_.Control(3, "contrast") == 90; })) << Report();
  EXPECT_TRUE(Until([&] { return devices_.Control(3, "exposure_time_absolute") == 100; }));
  EXPECT_EQ(devices_.Control(3, "brightness"), 77);
  ASSERT_TRUE(Until([&] { return Status().num_reconnects == 1; })) << Report();
  EXPECT_EQ(Status().serial, "CAM0");
  EXPECT_EQ(driver_->Stop(), 0) << Report();
}

TEST_F(V4l2Process, DepthArrivesAsTheDeviceMeasuredIt) {
  devices_.Describe(Node(0, ""));
  Start("pixel_format = \"Z16\"");
  ASSERT_TRUE(UntilImages(5)) << Report();
  const Result<DepthFrame> frame = DepthFrameFromMessage(listener_.images());
  ASSERT_TRUE(frame.ok()) << frame.error().message;
  EXPECT_EQ(frame->serial, "CAM0");
  ASSERT_EQ(frame->image.width, kWidth);
  ASSERT_EQ(frame->image.height, kHeight);
  int fewest_wrong = kWidth * kHeight;
  for (int phase = 0; phase < v4l2_shim::kNumPhases; ++phase) {
    int wrong = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const float truth = 1e-3F * v4l2_shim::DepthValue(x, y, phase);
        const float depth = frame->image.at(x, y);
        const bool right =
            truth == 0.0F ? std::isnan(depth) : std::abs(depth - truth) < 1e-6F * 4500.0F;
        if (!right) ++wrong;
      }
    }
    fewest_wrong = std::min(fewest_wrong, wrong);
  }
  EXPECT_EQ(fewest_wrong, 0);
}

TEST_F(V4l2Process, JpegIsSentAsItCame) {
  devices_.Describe(Node(0, "jpeg_tables no"));
  Start("pixel_format = \"MJPG\"\ncolor_encoding = \"mjpeg\"");
  ASSERT_TRUE(UntilImages(5)) << Report();
  const image_t& image = listener_.images().images.at(0);
  EXPECT_EQ(image.pixelformat, image_t::PIXEL_FORMAT_MJPEG);
  ASSERT_GT(image.data.size(), 4U);
  EXPECT_EQ(image.data[0], 0xFF);
  EXPECT_EQ(image.data[1], 0xD8);
  EXPECT_EQ(image.data.back(), 0xD9);
}

TEST_F(V4l2Process, CountsWhatIsBadAndWhatIsMissing) {
  devices_.Describe(
      Node(0, "fault error_flag every 5\nfault drop every 7\nfault bytesused 9 every 11"));
  Start("");
  ASSERT_TRUE(Until([&] { return Status().num_bad >= 10 && Status().num_missed >= 5; }))
      << Report();
  EXPECT_GE(Status().num_dropped, Status().num_bad);
  EXPECT_GE(Status().num_captured, Status().num_published + Status().num_bad);
  EXPECT_EQ(Status().num_reconnects, 0) << Report();
  EXPECT_GT(listener_.arrivals().size(), 10U);
  EXPECT_EQ(driver_->Stop(), 0);
}

TEST_F(V4l2Process, StatesFollowTheDevice) {
  devices_.Describe(Node(0, "fail OPEN EACCES"));
  Start("");
  ASSERT_TRUE(UntilMessage("usermod -aG video")) << Report();
  EXPECT_EQ(Status().state, camera_status_v2_t::SEARCHING);
  devices_.Describe(Node(0, ""));
  ASSERT_TRUE(UntilState(camera_status_v2_t::STREAMING)) << Report();
  devices_.Describe(Node(0, "fault stall"));
  ASSERT_TRUE(UntilState(camera_status_v2_t::STALLED)) << Report();
  devices_.Describe(Node(0, ""));
  ASSERT_TRUE(UntilState(camera_status_v2_t::STREAMING)) << Report();
  const int64_t reconnects = Status().num_reconnects;
  listener_.SendRestart();
  EXPECT_TRUE(Until([&] { return Status().num_reconnects > reconnects; })) << Report();
  EXPECT_TRUE(UntilImages(5)) << Report();
  EXPECT_EQ(driver_->Stop(), 0);
}

TEST_F(V4l2Process, ThatIsKilledLeavesTheDeviceToTheNext) {
  devices_.Describe(Node(0, ""));
  Start("");
  ASSERT_TRUE(UntilImages(5)) << Report();
  CameraListener second("SECOND");
  DriverProcess other(Config("SECOND", ""));
  ASSERT_TRUE(second.ListenForMessage("another program streams from it")) << second.Summary();
  EXPECT_TRUE(UntilImages(5)) << Report();
  EXPECT_TRUE(second.arrivals().empty());
  driver_.reset();  // Killed.
  EXPECT_TRUE(second.ListenForImages(5)) << second.Summary() << other.Output();
  EXPECT_EQ(other.Stop(), 0);
}

TEST_F(V4l2Process, EndsWhenAskedInEveryState) {
  Start("");
  ASSERT_TRUE(UntilState(camera_status_v2_t::SEARCHING)) << Report();
  EXPECT_EQ(driver_->Stop(), 0);
  devices_.Describe(Node(0, "fault stall after 10"));
  Start("");
  ASSERT_TRUE(UntilState(camera_status_v2_t::STALLED)) << Report();
  EXPECT_EQ(driver_->Stop(), 0);
}

// Anything after anything else, again and again: it goes on, and is well when the device is.
TEST_F(V4l2Process, SurvivesWhateverComes) {
  constexpr std::array kTroubles = {"fault stall",
                                    "fault error_flag",
                                    "fault corrupt 300",
                                    "fault bytesused 0xffffffff",
                                    "fault bytesused 0",
                                    "fault stamp -4000000000000000",
                                    "fault stamp 60000000 every 3",
                                    "fault stamp_still",
                                    "fault sequence 2000000000 every 2",
                                    "fault poll_error",
                                    "fault poll_hangup",
                                    "fault endless",
                                    "fault unterminated",
                                    "fail DQBUF ENODEV",
                                    "fail DQBUF EIO",
                                    "fail QBUF EINVAL",
                                    "fail MMAP ENOMEM",
                                    "fail OPEN EACCES",
                                    "fail QUERYCAP EIO",
                                    "fail STREAMON ENOSPC",
                                    "fail STREAMOFF EIO",
                                    "fail S_PARM EIO",
                                    "fail G_FMT EINVAL",
                                    "override buffer_count 1",
                                    "override buffer_length 0x7fffffff",
                                    "override sizeimage 0x7fffffff",
                                    "override bytesperline 0x7fffffff",
                                    "override width 0",
                                    "override pixelformat MJPG",
                                    "kind output",
                                    "kind null",
                                    "kind file",
                                    "serial OTHER",
                                    "padding 64"};
  Rng rng(7);
  devices_.Describe(Node(0, ""));
  Start("");
  ASSERT_TRUE(UntilImages(3)) << Report();
  for (int i = 0; i < 60; ++i) {
    std::string lines;
    for (uint32_t n = rng.Below(3); n > 0; --n) {
      lines += std::string(kTroubles.at(rng.Below(uint32_t{kTroubles.size()}))) + "\n";
    }
    const int number = static_cast<int>(rng.Below(3));
    devices_.Describe(rng.Below(8) == 0 ? "" : Node(number, lines));
    listener_.ListenFor(std::chrono::milliseconds(60));
    ASSERT_TRUE(driver_->IsRunning()) << "after " << lines << Report();
  }
  devices_.Describe(Node(1, ""));
  ASSERT_TRUE(UntilImages(5)) << Report();
  EXPECT_TRUE(UntilState(camera_status_v2_t::STREAMING)) << Report();
  EXPECT_EQ(driver_->Stop(), 0) << Report();
}

TEST(V4l2List, TellsWhatDevicesCanDo) {
  const EmulatedDevices devices;
  EXPECT_NE(RunList().find("no V4L2 device"), std::string::npos) << RunList();
  devices.Describe(Node(0, "card Left Eye\ncontrol power_line_frequency 0 2 1 1") +
                   "device 4\nkind metadata\n" + "device 5\nfail OPEN EACCES\n");
  const std::string list = RunList();
  for (const char* part : {"/dev/video0",
                           "Left Eye",
                           "CAM0",
                           "YUYV",
                           "64x48",
                           "30 Hz",
                           "power_line_frequency",
                           "60 Hz",
                           "/dev/video4",
                           "/dev/video5",
                           "exit code 0"}) {
    EXPECT_NE(list.find(part), std::string::npos) << part << " in:\n" << list;
  }
}

TEST(V4l2List, EndsWithAnyDevice) {
  const EmulatedDevices devices;
  for (const char* trouble : {"fault endless\ncontrol gain 0 9 1 1",
                              "fault unterminated",
                              "fail QUERYCAP EIO",
                              "kind null",
                              "kind file",
                              "format YUYV 4294967295x0 0/0"}) {
    devices.Describe(Node(0, trouble));
    const std::string list = RunList();
    EXPECT_NE(list.find("exit code 0"), std::string::npos) << trouble << "\n" << list;
    EXPECT_LT(list.size(), 20'000U) << trouble;
  }
}

}  // namespace
}  // namespace vantage
