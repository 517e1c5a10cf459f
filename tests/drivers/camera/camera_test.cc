#include "drivers/camera/camera.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "common/format.h"
#include "tests/drivers/camera/fake_camera.h"

namespace vantage {
namespace {

using std::chrono::milliseconds;
using Fault = FakeHost::Fault;

class CameraTest : public testing::Test {
 protected:
  void Create(const std::string& device) {
    Result<DeviceSelector> selector = DeviceSelector::Parse(device);
    ASSERT_TRUE(selector.ok()) << selector.error().message;
    options_.device = *selector;
    options_.on_change = [this](const CameraStatus& status) { states_.push_back(status.state); };
    Result<std::unique_ptr<Camera>> camera =
        Camera::Create(options_, std::make_unique<FakeApi>(host_));
    ASSERT_TRUE(camera.ok()) << camera.error().message;
    camera_ = std::move(camera).value();
  }
  // Good frames of `seconds` on the fake's clock.
  int GrabFor(double seconds) {
    const int64_t end = host_.now_us + static_cast<int64_t>(1e6 * seconds);
    int num_frames = 0;
    while (host_.now_us < end) {
      if (const auto frame = camera_->Grab(milliseconds(100))) {
        last_ = *frame;
        ++num_frames;
      }
    }
    return num_frames;
  }
  [[nodiscard]] CameraState state() const { return camera_->status().state; }
  [[nodiscard]] std::string message() const { return camera_->status().message; }

  FakeHost host_;
  Camera::Options options_;
  std::unique_ptr<Camera> camera_;
  std::vector<CameraState> states_;
  CameraFrame last_;
};

TEST_F(CameraTest, StreamsFromTheFirstDevice) {
  host_.devices["usb/1"] = {.serial = "A"};
  Create("index:0");
  EXPECT_EQ(GrabFor(1.99), 60);
  EXPECT_EQ(state(), CameraState::kStreaming);
  EXPECT_EQ(message(), "");
  EXPECT_EQ(camera_->status().serial, "A");
  EXPECT_EQ(camera_->status().num_captured, 60);
  EXPECT_NEAR(camera_->status().fps, 30.0, 0.1);
  EXPECT_EQ(states_, (std::vector<CameraState>{CameraState::kOpening, CameraState::kStreaming}));
  EXPECT_EQ(last_.serial, "A");
  EXPECT_EQ(last_.depth_mm.front(), 500);
  EXPECT_EQ(last_.depth_mm.back(), 500 + FakeHost::kWidth * FakeHost::kHeight - 1);
  // fx = W / (2 tan(HFOV / 2))
  EXPECT_NEAR(last_.model->fx, 4.0 / std::tan(0.5), 1e-12);
  EXPECT_NEAR(last_.model->cy, 2.5, 1e-12);
}

TEST_F(CameraTest, TimeIsTheHostsTime) {
  host_.devices["usb/1"] = {.serial = "A"};
  Create("index:0");
  GrabFor(1.0);
  EXPECT_EQ(last_.utime, host_.now_us + host_.wall_offset_us);
  EXPECT_EQ(last_.device_time_us, host_.now_us + host_.device_offset_us);
  EXPECT_NEAR(camera_->status().clock_offset_s,
              1e-6 * static_cast<double>(host_.wall_offset_us - host_.device_offset_us),
              1e-3);
}

TEST_F(CameraTest, SearchesWithoutBusyLoopUntilADeviceComes) {
  Create("serial:A");
  EXPECT_EQ(GrabFor(10.0), 0);
  EXPECT_EQ(state(), CameraState::kSearching);
  EXPECT_LE(host_.num_lists, 21);
  EXPECT_GE(host_.num_lists, 19);
  EXPECT_EQ(message(),
            "no fake device matches serial:A (found: none); waiting for one; plug one in");
  host_.devices["usb/1"] = {.serial = "A"};
  EXPECT_GT(GrabFor(1.0), 10);
}

TEST_F(CameraTest, ConnectionEventEndsTheWait) {
  Create("index:0");
  camera_->Grab(milliseconds(100));
  host_.devices["usb/1"] = {.serial = "A"};
  host_.pressed_by_event = true;
  camera_->Grab(milliseconds(100));
  EXPECT_EQ(state(), CameraState::kStreaming);
}

TEST_F(CameraTest, FindsASerialAmongSeveralAndOpensOthersOnce) {
  host_.devices["usb/1"] = {.serial = "A"};
  host_.devices["usb/2"] = {.serial = "B"};
  Create("serial:C");
  GrabFor(10.0);
  EXPECT_EQ(host_.num_opened, 2);
  EXPECT_EQ(host_.num_open, 0);
  EXPECT_NE(message().find("found: usb/1 (serial A), usb/2 (serial B)"), std::string::npos);
  host_.devices["usb/3"] = {.serial = "C"};
  EXPECT_GT(GrabFor(1.0), 10);
  EXPECT_EQ(host_.num_opened, 3);
  EXPECT_EQ(last_.serial, "C");
}

TEST_F(CameraTest, SelectsByUri) {
  host_.devices["usb/1"] = {.serial = "A"};
  host_.devices["usb/2"] = {.serial = "B"};
  Create("uri:usb/2");
  GrabFor(0.2);
  EXPECT_EQ(camera_->status().serial, "B");
}

TEST_F(CameraTest, UnpluggedItResumesBySerialAtAnotherPort) {
  host_.devices["usb/1"] = {.serial = "A"};
  Create("index:0");
  GrabFor(1.0);
  host_.devices.clear();
  camera_->Grab(milliseconds(100));
  EXPECT_EQ(state(), CameraState::kLost);
  EXPECT_EQ(host_.num_open, 0);
  EXPECT_EQ(GrabFor(2.0), 0);
  EXPECT_EQ(state(), CameraState::kSearching);
  EXPECT_EQ(camera_->status().serial, "A");
  // Another device now comes first; it is not the one.
  host_.devices["usb/0"] = {.serial = "Z"};
  EXPECT_EQ(GrabFor(2.0), 0);
  EXPECT_NE(message().find("matches serial:A (found: usb/0 (serial Z))"), std::string::npos);
  host_.devices["usb/9"] = {.serial = "A"};
  EXPECT_GT(GrabFor(1.0), 10);
  EXPECT_EQ(last_.serial, "A");
  EXPECT_EQ(camera_->status().num_reconnects, 1);
  const std::vector<CameraState> begin(states_.begin(), states_.begin() + 4);
  EXPECT_EQ(begin,
            (std::vector<CameraState>{CameraState::kOpening,
                                      CameraState::kStreaming,
                                      CameraState::kLost,
                                      CameraState::kSearching}));
}

TEST_F(CameraTest, WithoutSerialItResumesByTheSelector) {
  host_.devices["usb/1"] = {};
  Create("index:0");
  GrabFor(0.2);
  EXPECT_EQ(camera_->status().serial, "usb/1");
  host_.devices.clear();
  GrabFor(1.0);
  host_.devices["usb/2"] = {};
  EXPECT_GT(GrabFor(1.0), 10);
  EXPECT_EQ(camera_->status().serial, "usb/2");
}

TEST_F(CameraTest, ShortStallPassesWithoutReopening) {
  host_.devices["usb/1"] = {.serial = "A"};
  Create("index:0");
  GrabFor(1.0);
  host_.stalled = true;
  EXPECT_EQ(GrabFor(0.8), 0);
  EXPECT_EQ(state(), CameraState::kStreaming);
  EXPECT_EQ(GrabFor(0.7), 0);
  EXPECT_EQ(state(), CameraState::kStalled);
  EXPECT_NE(message().find("device A gives no frame for"), std::string::npos);
  host_.stalled = false;
  EXPECT_GT(GrabFor(0.2), 0);
  EXPECT_EQ(state(), CameraState::kStreaming);
  EXPECT_EQ(message(), "");
  EXPECT_EQ(host_.num_opened, 1);
}

TEST_F(CameraTest, LongStallReopens) {
  host_.devices["usb/1"] = {.serial = "A"};
  Create("index:0");
  GrabFor(1.0);
  host_.stalled = true;
  GrabFor(7.0);
  EXPECT_EQ(host_.num_opened, 3);
  host_.stalled = false;
  EXPECT_GT(GrabFor(1.0), 10);
  EXPECT_EQ(camera_->status().num_reconnects, 2);
}

TEST_F(CameraTest, MalformedFramesAreCountedAndDropped) {
  host_.devices["usb/1"] = {.serial = "A"};
  host_.faults = {
      Fault::kNone, Fault::kShort, Fault::kWrongSize, Fault::kWrongStride, Fault::kNoData};
  Create("index:0");
  camera_->Grab(milliseconds(100));  // Opens.
  EXPECT_TRUE(camera_->Grab(milliseconds(100)).has_value());
  for (int64_t bad = 1; bad <= 4; ++bad) {
    EXPECT_FALSE(camera_->Grab(milliseconds(100)).has_value());
    EXPECT_EQ(camera_->status().num_bad, bad);
    EXPECT_NE(message().find("device A: depth frame of"), std::string::npos) << message();
  }
  EXPECT_TRUE(camera_->Grab(milliseconds(100)).has_value());
  EXPECT_EQ(message(), "");
  EXPECT_EQ(camera_->status().num_captured, 6);
}

TEST_F(CameraTest, RefusalIsToldAndRetriedSlowly) {
  host_.devices["usb/1"] = {.serial = "A", .refuses_to_open = true};
  Create("index:0");
  GrabFor(10.0);
  EXPECT_EQ(state(), CameraState::kSearching);
  EXPECT_NE(message().find("permission denied"), std::string::npos);
  EXPECT_LE(states_.size(), 12U);  // Two changes a try.
  host_.devices["usb/1"].refuses_to_open = false;
  EXPECT_GT(GrabFor(3.0), 10);
}

TEST_F(CameraTest, UnsupportedModeIsTold) {
  host_.devices["usb/1"] = {.serial = "A"};
  options_.stream.fps = 77;
  Create("index:0");
  GrabFor(1.0);
  EXPECT_EQ(state(), CameraState::kSearching);
  EXPECT_EQ(message(), "no depth mode at that rate");
}

TEST_F(CameraTest, WithoutFieldOfViewAndCalibrationThereIsNoModel) {
  host_.devices["usb/1"] = {.serial = "A"};
  host_.details.horizontal_fov = 0.0;
  host_.details.vertical_fov = 0.0;
  Create("index:0");
  EXPECT_GT(GrabFor(0.5), 5);
  EXPECT_FALSE(last_.model.has_value());
  EXPECT_EQ(last_.width, FakeHost::kWidth);
  EXPECT_NE(message().find("it does not tell its field of view"), std::string::npos);
}

TEST_F(CameraTest, FramesThatTheDeviceCountedAndThatNeverCameAreCounted) {
  host_.devices["usb/1"] = {.serial = "A"};
  Create("index:0");
  GrabFor(0.5);
  EXPECT_EQ(camera_->status().num_missed, 0);
  host_.frame_index += 7;
  GrabFor(0.5);
  EXPECT_EQ(camera_->status().num_missed, 7);
  host_.frame_index = 0;  // It counts anew.
  GrabFor(0.5);
  EXPECT_EQ(camera_->status().num_missed, 7);
}

TEST_F(CameraTest, FramesThatTheDeviceMarksAsBadAreCountedAndTold) {
  host_.devices["usb/1"] = {.serial = "A"};
  host_.faults.assign(3, Fault::kMarked);
  Create("index:0");
  camera_->Grab(milliseconds(100));
  EXPECT_EQ(camera_->Grab(milliseconds(100)), std::nullopt);
  EXPECT_EQ(camera_->status().num_bad, 1);
  EXPECT_EQ(message(), "device A: marked as bad");
  EXPECT_GT(GrabFor(0.5), 5);
  EXPECT_EQ(camera_->status().num_bad, 3);
  EXPECT_EQ(camera_->status().num_missed, 0);
}

TEST_F(CameraTest, AnAliasOfTheListIsFound) {
  host_.devices["usb/1"] = {.serial = "A"};
  host_.devices["usb/2"] = {.serial = "B"};
  Create("id:fake-usb/2");
  GrabFor(0.5);
  EXPECT_EQ(last_.serial, "B");
}

TEST_F(CameraTest, CalibrationStandsInForTheFieldOfView) {
  host_.devices["usb/1"] = {.serial = "A"};
  host_.details.horizontal_fov = 0.0;
  Create("index:0");
  GrabFor(0.5);
  EXPECT_NE(message().find("field of view"), std::string::npos);

  CameraModel model;
  model.width = FakeHost::kWidth;
  model.height = FakeHost::kHeight;
  model.fx = 7.5;
  options_.calibration.emplace().intrinsics.camera = model;
  Create("index:0");
  EXPECT_GT(GrabFor(0.5), 5);
  EXPECT_EQ(last_.model, model);

  options_.calibration->intrinsics.camera.width = 640;
  Create("index:0");
  GrabFor(0.5);
  EXPECT_NE(message().find("gives images of 8 x 6 px, expected the 640 x 6 px"), std::string::npos);
}

TEST_F(CameraTest, MirroredFinerDepthBecomesPlainMillimetres) {
  host_.devices["usb/1"] = {.serial = "A"};
  host_.details.mirrored = true;
  host_.details.depth_unit_um = 100;
  host_.with_color = true;
  Create("index:0");
  GrabFor(0.2);
  EXPECT_EQ(last_.depth_mm[0], 51);  // 507 of 0.1 mm, the row's last
  EXPECT_EQ(last_.depth_mm[FakeHost::kWidth], 52);
  EXPECT_EQ(last_.color->width, FakeHost::kWidth);
  EXPECT_EQ(last_.color->data.size(), 3U * FakeHost::kWidth * FakeHost::kHeight);
}

TEST_F(CameraTest, RestartOpensAnew) {
  host_.devices["usb/1"] = {.serial = "A"};
  Create("index:0");
  GrabFor(0.5);
  camera_->Restart();
  EXPECT_EQ(host_.num_open, 0);
  EXPECT_GT(GrabFor(0.5), 5);
  EXPECT_EQ(host_.num_opened, 2);
}

TEST_F(CameraTest, SettingsReachTheDeviceOrSayWhyNot) {
  Create("index:0");
  EXPECT_FALSE(camera_->SetExposure(100).ok());
  host_.devices["usb/1"] = {.serial = "A"};
  GrabFor(1.0);
  EXPECT_TRUE(camera_->SetExposure(100).ok());
  EXPECT_EQ(host_.exposure_us, 100);
  EXPECT_FALSE(camera_->SetGain(1).ok());
}

class Openni2RecordingTest : public CameraTest {
 protected:
  Openni2RecordingTest() {
    host_.details.is_recording = true;
    host_.frames_until_end = 30;
    std::ofstream(path_) << "NI10 and more";
  }
  ~Openni2RecordingTest() override { std::filesystem::remove(path_); }

  std::string path_ = testing::TempDir() + Format("camera_test.%d.oni", getpid());
};

TEST_F(Openni2RecordingTest, PlaysAtItsOwnSpeedAndEnds) {
  Create("oni:" + path_);
  const int64_t start_us = host_.now_us;
  std::vector<int64_t> utimes;
  while (state() != CameraState::kLost) {
    if (const auto frame = camera_->Grab(milliseconds(100))) utimes.push_back(frame->utime);
  }
  ASSERT_EQ(utimes.size(), 30U);
  for (size_t i = 1; i < utimes.size(); ++i) {
    EXPECT_EQ(utimes[i] - utimes[i - 1], FakeHost::kPeriodUs);
  }
  EXPECT_EQ(host_.now_us - start_us, 29 * FakeHost::kPeriodUs);
  EXPECT_EQ(state(), CameraState::kLost);
  EXPECT_NE(message().find(".oni is over; the command"), std::string::npos);
  EXPECT_EQ(GrabFor(1.0), 0);

  host_.frames_until_end = 5;
  camera_->Restart();
  EXPECT_EQ(GrabFor(1.0), 5);
}

TEST_F(Openni2RecordingTest, AbsentOrOtherFilesAreErrors) {
  const auto error = [this](const std::string& path) {
    options_.device = *DeviceSelector::Parse("oni:" + path);
    const auto camera = Camera::Create(options_, std::make_unique<FakeApi>(host_));
    return camera.ok() ? std::string() : camera.error().message;
  };
  EXPECT_EQ(error("/no/such.oni"), "recording /no/such.oni: no such file, expected an .oni file");
  std::ofstream(path_) << "PNG";
  EXPECT_NE(error(path_).find("no OpenNI2 recording"), std::string::npos);
}

TEST(DeviceSelector, ParsesEveryKindAndRefusesTheRest) {
  for (const char* good :
       {"index:0", "index:12", "uri:1d27/0601@1/5", "serial:X 1", "oni:/a/b.oni"}) {
    const Result<DeviceSelector> selector = DeviceSelector::Parse(good);
    ASSERT_TRUE(selector.ok()) << good;
    EXPECT_EQ(selector->Text(), good);
  }
  for (const char* bad :
       {"", "index:", "index:-1", "index:100", "index:1x", "serial:", "usb:1", "0"}) {
    const Result<DeviceSelector> selector = DeviceSelector::Parse(bad);
    ASSERT_FALSE(selector.ok()) << bad;
    EXPECT_NE(selector.error().message.find("expected \"index:N\""), std::string::npos);
  }
}

}  // namespace
}  // namespace vantage
