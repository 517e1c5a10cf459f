#include "nodes/camera_node.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <map>
#include <mutex>
#include <thread>

#include "bus/conversions.h"
#include "bus/image_conversion.h"
#include "tests/drivers/camera/fake_camera.h"
#include "vantage/camera_command_v2_t.hpp"
#include "vantage/camera_info_t.hpp"
#include "vantage/camera_status_v2_t.hpp"

namespace vantage {
namespace {

// Keeps what is published; any thread may publish.
class MemoryBus : public Bus {
 public:
  template <class Message>
  std::vector<Message> Published(const std::string& channel) {
    const std::lock_guard lock(mutex_);
    std::vector<Message> messages;
    for (const std::vector<std::byte>& bytes : published_[channel]) {
      const Result<Message> message = DecodeChecked<Message>(bytes);
      EXPECT_TRUE(message.ok());
      if (message) messages.push_back(*message);
    }
    return messages;
  }
  template <class Message>
  void Deliver(const std::string& channel, const Message& message) {
    ASSERT_TRUE(handlers_.contains(channel));
    EXPECT_TRUE(handlers_[channel]({channel, 0}, Encode(message)));
  }

  void RecordStage(const std::string& stage, double) override {
    const std::lock_guard lock(mutex_);
    ++stages_[stage];
  }
  void RecordLost(const std::string&, int64_t) override {}
  void SetState(const std::string& state) override { state_ = state; }
  [[nodiscard]] int64_t NowUtime() const override { return 1'800'000'000'000'000; }

  std::map<std::string, int> stages_;
  std::string state_;

 protected:
  Result<void> SubscribeBytes(const std::string& channel,
                              int64_t,
                              SubscribeOptions,
                              BytesHandler handler) override {
    handlers_[channel] = std::move(handler);
    return {};
  }
  Result<void> PublishBytes(const std::string& channel, std::span<const std::byte> bytes) override {
    const std::lock_guard lock(mutex_);
    published_[channel].emplace_back(bytes.begin(), bytes.end());
    return {};
  }

 private:
  std::mutex mutex_;
  std::map<std::string, std::vector<std::vector<std::byte>>> published_;
  std::map<std::string, BytesHandler> handlers_;
};

class CameraNodeTest : public testing::Test {
 protected:
  CameraNodeTest() {
    config_.name = "XTION";
    config_.device = *DeviceSelector::Parse("index:0");
    config_.rate_hz = 0.0;
    host_.devices["usb/1"] = {.serial = "A"};
    // The fake's clock runs thirty times as fast as ours; the step runs on the capture thread.
    host_.on_time = [this] {
      if (step_) step_();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    };
  }
  void Start() {
    Result<std::unique_ptr<Node>> node =
        MakeCameraNode(bus_, config_, "openni2", std::make_unique<FakeApi>(host_));
    ASSERT_TRUE(node.ok()) << node.error().message;
    node_ = std::move(node).value();
  }
  // Polls until `done`; a minute is a bound against hanging, not an expectation.
  template <class Condition>
  [[nodiscard]] bool PollUntil(Condition done) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::minutes(1);
    while (std::chrono::steady_clock::now() < deadline) {
      node_->Poll();
      if (done()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return false;
  }
  [[nodiscard]] std::vector<images_t> Images() { return bus_.Published<images_t>("CAMERA_XTION"); }
  [[nodiscard]] std::vector<camera_status_v2_t> Statuses() {
    return bus_.Published<camera_status_v2_t>("CAMERA_XTION_STATUS");
  }

  FakeHost host_;
  std::function<void()> step_;
  int num_steps_ = 0;  // Of the capture thread.
  std::atomic<bool> plugged_ = false;
  MemoryBus bus_;
  CameraConfig config_;
  std::unique_ptr<Node> node_;  // Last: its threads end first.
};

TEST_F(CameraNodeTest, PublishesImagesInfoAndStatus) {
  Start();
  ASSERT_TRUE(PollUntil([this] {
    return Images().size() >= 5 && !bus_.Published<camera_info_t>("CAMERA_XTION_INFO").empty() &&
           Statuses().size() >= 2;
  }));
  int64_t seq = 0;
  for (const images_t& message : Images()) {
    const Result<DepthFrame> frame = DepthFrameFromMessage(message);
    ASSERT_TRUE(frame.ok()) << frame.error().message;
    EXPECT_EQ(frame->seq, seq++);
    EXPECT_EQ(frame->serial, "A");
    EXPECT_EQ(frame->image.width, FakeHost::kWidth);
    EXPECT_FLOAT_EQ(frame->image.depth[3], 0.503F);
    EXPECT_EQ(message.image_types[0], images_t::DEPTH_MM_VDC);
  }
  const camera_info_t info = bus_.Published<camera_info_t>("CAMERA_XTION_INFO").front();
  const Result<CameraModel> model = CameraFromMessage(info);
  ASSERT_TRUE(model.ok()) << model.error().message;
  EXPECT_NEAR(model->fx, 4.0 / std::tan(0.5), 1e-12);
  EXPECT_EQ(info.serial, "A");
  EXPECT_EQ(info.calibration_id, "field of view");
  const camera_status_v2_t status = Statuses().back();
  EXPECT_EQ(status.state, camera_status_v2_t::STREAMING);
  EXPECT_EQ(status.serial, "A");
  EXPECT_EQ(bus_.state_, "ok");
  EXPECT_GE(bus_.stages_["compress"], 5);
  EXPECT_GE(bus_.stages_["capture_to_publish"], 5);
}

// What estimators are told of the camera is true of the depth that they get.
TEST_F(CameraNodeTest, DistortionIsTakenOutBeforeItIsPublished) {
  CameraCalibration calibration;
  calibration.intrinsics.camera = {.width = FakeHost::kWidth,
                                   .height = FakeHost::kHeight,
                                   .fx = 8.0,
                                   .fy = 8.0,
                                   .cx = 3.5,
                                   .cy = 2.5};
  calibration.intrinsics.distortion.k1 = 1.0;
  config_.calibration = calibration;
  Start();
  ASSERT_TRUE(PollUntil([this] {
    return !Images().empty() && !bus_.Published<camera_info_t>("CAMERA_XTION_INFO").empty();
  }));
  const camera_info_t info = bus_.Published<camera_info_t>("CAMERA_XTION_INFO").front();
  EXPECT_EQ(info.distortion_model, "none");
  const Result<CameraModel> model = CameraFromMessage(info);
  ASSERT_TRUE(model.ok()) << model.error().message;
  EXPECT_EQ(*model, calibration.intrinsics.camera);
  const Result<DepthFrame> frame = DepthFrameFromMessage(Images().front());
  ASSERT_TRUE(frame.ok()) << frame.error().message;
  std::vector<uint16_t> taken;  // The fake's pixel i has the depth 500 mm + i.
  for (int i = 0; i < FakeHost::kWidth * FakeHost::kHeight; ++i) {
    taken.push_back(static_cast<uint16_t>(500 + i));
  }
  const std::vector<int32_t> map = UndistortionMap(calibration.intrinsics);
  EXPECT_EQ(DepthToMillimetres(frame->image), Undistort(taken, map));
  EXPECT_NE(DepthToMillimetres(frame->image), taken);
}

TEST_F(CameraNodeTest, SurvivesUnplugging) {
  step_ = [this] {
    ++num_steps_;
    if (host_.frame_index == 20) host_.devices.clear();
    if (host_.devices.empty() && num_steps_ == 60) host_.devices["usb/7"] = {.serial = "A"};
  };
  Start();
  ASSERT_TRUE(PollUntil([this] {
    const std::vector<camera_status_v2_t> statuses = Statuses();
    return statuses.back().state == camera_status_v2_t::STREAMING &&
           statuses.back().num_reconnects == 1;
  }));
  std::vector<int> states;
  for (const camera_status_v2_t& status : Statuses()) {
    if (states.empty() || states.back() != status.state) states.push_back(status.state);
  }
  const std::vector<int> expected = {camera_status_v2_t::OPENING,
                                     camera_status_v2_t::STREAMING,
                                     camera_status_v2_t::LOST,
                                     camera_status_v2_t::SEARCHING,
                                     camera_status_v2_t::OPENING,
                                     camera_status_v2_t::STREAMING};
  if (states.front() == camera_status_v2_t::SEARCHING) states.erase(states.begin());
  EXPECT_EQ(states, expected);
  int64_t seq = 0;
  for (const images_t& message : Images()) EXPECT_EQ(ImageSeq(message.images[0]), seq++);
}

TEST_F(CameraNodeTest, WithoutADeviceItSaysWhatItLooksFor) {
  host_.devices.clear();
  config_.device = *DeviceSelector::Parse("serial:X1");
  Start();
  ASSERT_TRUE(PollUntil([this] {
    return !Statuses().empty() &&
           Statuses().back().message.find("no fake device matches serial:X1 (found: none)") !=
               std::string::npos;
  }));
  EXPECT_EQ(Statuses().back().state, camera_status_v2_t::SEARCHING);
  EXPECT_NE(bus_.state_.find("serial:X1"), std::string::npos);
  EXPECT_TRUE(Images().empty());
}

TEST_F(CameraNodeTest, RateLimitLeavesFramesOut) {
  config_.rate_hz = 10.0;
  Start();
  ASSERT_TRUE(PollUntil([this] { return Images().size() >= 6; }));
  const std::vector<images_t> images = Images();
  for (size_t i = 1; i < images.size(); ++i) {
    EXPECT_GE(images[i].utime - images[i - 1].utime, 75'000);
  }
}

TEST_F(CameraNodeTest, ObeysCommands) {
  Start();
  ASSERT_TRUE(PollUntil([this] { return !Images().empty(); }));
  camera_command_v2_t command{};
  command.exposure_us = 5000;
  command.gain = 3;  // The fake has none.
  command.rate = 0.0;
  bus_.Deliver("CAMERA_XTION_COMMAND", command);
  ASSERT_TRUE(PollUntil([this] {
    return Statuses().back().message.find("gain: the device has no such setting") !=
           std::string::npos;
  }));

  command = camera_command_v2_t{};
  command.exposure_us = -1;
  command.gain = -1;
  command.restart = 1;
  bus_.Deliver("CAMERA_XTION_COMMAND", command);
  ASSERT_TRUE(PollUntil([this] { return Statuses().back().num_reconnects == 1; }));

  command.restart = 0;
  command.rate = std::nan("");
  bus_.Deliver("CAMERA_XTION_COMMAND", command);
  ASSERT_TRUE(PollUntil([this] {
    return Statuses().back().message.find("command ignored: rate = nan") != std::string::npos;
  }));
  node_.reset();
  EXPECT_EQ(host_.exposure_us, 5000);
}

TEST_F(CameraNodeTest, SettingsAskedForBeforeThereIsADeviceAreApplied) {
  host_.devices.clear();
  step_ = [this] {
    if (plugged_ && host_.devices.empty()) host_.devices["usb/1"] = {.serial = "A"};
  };
  Start();
  camera_command_v2_t command{};
  command.exposure_us = 5000;
  command.gain = -1;
  bus_.Deliver("CAMERA_XTION_COMMAND", command);
  ASSERT_TRUE(PollUntil([this] {
    return !Statuses().empty() &&
           Statuses().back().message.find("exposure not set: no device yet") != std::string::npos;
  }));
  plugged_ = true;
  ASSERT_TRUE(PollUntil([this] { return Images().size() >= 3; }));
  node_.reset();
  EXPECT_EQ(host_.exposure_us, 5000);
}

TEST_F(CameraNodeTest, AClockThatStepsIsTold) {
  step_ = [this] {
    if (host_.frame_index == 10 && num_steps_++ == 0) host_.wall_offset_us -= 60'000'000;
  };
  Start();
  ASSERT_TRUE(PollUntil([this] {
    return !Statuses().empty() &&
           Statuses().back().message.find("was set or started anew (1 times") != std::string::npos;
  }));
}

TEST_F(CameraNodeTest, MalformedFramesAreCountedAndNotSent) {
  for (int i = 0; i < 200; ++i) {
    host_.faults.push_back(i % 2 == 0 ? FakeHost::Fault::kShort : FakeHost::Fault::kNone);
  }
  Start();
  ASSERT_TRUE(PollUntil([this] { return !Statuses().empty() && Statuses().back().num_bad > 3; }));
  const camera_status_v2_t status = Statuses().back();
  EXPECT_GE(status.num_dropped, status.num_bad);
  EXPECT_GT(status.num_captured, status.num_published);
}

}  // namespace
}  // namespace vantage
