// The camera class through the ordinary OpenNI2 API, on the simulated device.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <string>
#include <vector>

#include "tests/drivers/openni2_plugin/openni2_fixture.h"

namespace vantage {
namespace {

using std::chrono::milliseconds;

TEST_F(Openni2Plugin, StreamsByIndexUriAndSerial) {
  const std::string serial = kTestSerial;
  for (const std::string& device :
       {std::string("index:0"), "uri:vantage-sim://" + serial, "serial:" + serial}) {
    Create(device);
    frames_.clear();
    ASSERT_TRUE(GrabFrames(3)) << device << ": " << camera_->status().message;
    const CameraFrame& frame = frames_.back();
    EXPECT_EQ(frame.serial, serial);
    EXPECT_EQ(frame.depth_mm, ExpectedImages().Depth());
    EXPECT_NEAR(frame.model->fx, 570.34, 1e-3);
    EXPECT_NEAR(frame.model->fy, 570.34, 1e-3);
    EXPECT_EQ(frame.model->cx, 319.5);
    EXPECT_GT(frame.device_time_us, frames_[frames_.size() - 2].device_time_us);
    EXPECT_GT(frame.utime, frames_[frames_.size() - 2].utime);
    camera_.reset();
  }
}

TEST_F(Openni2Plugin, AnAbsentSerialIsWaitedFor) {
  Create("serial:other");
  ASSERT_TRUE(GrabUntil([this] { return !camera_->status().message.empty(); }));
  EXPECT_EQ(camera_->status().state, CameraState::kSearching);
  EXPECT_NE(camera_->status().message.find("(serial " + std::string(kTestSerial) + ")"),
            std::string::npos)
      << camera_->status().message;
}

TEST_F(Openni2Plugin, ComesBackAfterUnplugging) {
  Create("index:0");
  ASSERT_TRUE(GrabFrames(3));
  Fault(SimFault::Kind::kUnplug);
  ASSERT_TRUE(GrabUntil([this] { return camera_->status().state == CameraState::kSearching; }));
  EXPECT_NE(std::ranges::find(states_, CameraState::kLost), states_.end());
  Fault(SimFault::Kind::kReplug);
  ASSERT_TRUE(GrabUntil([this] { return camera_->status().num_reconnects == 1; }));
  EXPECT_TRUE(GrabFrames(3));
  EXPECT_EQ(frames_.back().serial, kTestSerial);
}

TEST_F(Openni2Plugin, NoticesAStallAndReopens) {
  options_.stall_timeout = milliseconds(150);
  Create("index:0");
  ASSERT_TRUE(GrabFrames(3));
  Fault(SimFault::Kind::kStall);
  ASSERT_TRUE(GrabUntil([this] { return camera_->status().state == CameraState::kStalled; }));
  ASSERT_TRUE(GrabUntil([this] { return camera_->status().num_reconnects == 1; }));
  Fault(SimFault::Kind::kReplug);
  EXPECT_TRUE(GrabFrames(3));
}

TEST_F(Openni2Plugin, CountsAndDropsAShortFrame) {
  Create("index:0");
  ASSERT_TRUE(GrabFrames(3));
  Fault(SimFault::Kind::kShortFrame);
  ASSERT_TRUE(GrabUntil([this] { return camera_->status().num_bad == 1; }));
  ASSERT_TRUE(GrabFrames(3));
  for (const CameraFrame& frame : frames_) EXPECT_EQ(frame.depth_mm.size(), 640U * 480U);
}

TEST_F(Openni2Plugin, GivesColorOfTheSameTime) {
  options_.stream.color = true;
  options_.stream.registration = Registration::kDepthToColor;
  Create("index:0");
  ASSERT_TRUE(GrabUntil([this] { return !frames_.empty() && frames_.back().color; }))
      << camera_->status().message;
  EXPECT_EQ(frames_.back().color->data.size(), 640U * 480U * 3U);
  EXPECT_TRUE(frames_.back().registered);
}

TEST_F(Openni2Plugin, AModeThatItLacksIsToldWithThoseItHas) {
  options_.stream.fps = 17;
  Create("index:0");
  ASSERT_TRUE(GrabUntil([this] {
    return camera_->status().message.find("expected one of: 640x480 at 30 Hz in 1 mm") !=
           std::string::npos;
  })) << camera_->status().message;
}

// What a device gives that is no frame is counted, and the next good one is published.
TEST_F(Openni2Plugin, HostileFramesAreCountedAndDropped) {
  options_.stream.color = true;
  Create("index:0");
  ASSERT_TRUE(GrabFrames(2));
  for (const SimFault::Kind kind :
       {SimFault::Kind::kNoData, SimFault::Kind::kResized, SimFault::Kind::kAbsurdSize}) {
    const int64_t num_bad = camera_->status().num_bad;
    Fault(kind);
    ASSERT_TRUE(GrabUntil([&] { return camera_->status().num_bad > num_bad; }));
    Fault(kind, 0.2);
    ASSERT_TRUE(GrabUntil([&] { return camera_->status().num_bad > num_bad + 1; }));
    ASSERT_TRUE(GrabFrames(2)) << camera_->status().message;
  }
  const std::vector<uint16_t> expected = ExpectedImages().Depth();
  for (const CameraFrame& frame : frames_) {
    EXPECT_EQ(frame.depth_mm, expected);
    EXPECT_TRUE(!frame.color || frame.color->data.size() == 640U * 480U * 3U);
  }
  EXPECT_EQ(camera_->status().num_reconnects, 0);
}

TEST_F(Openni2Plugin, StampsThatGoBackDoNoHarm) {
  options_.stream.color = true;
  Create("index:0");
  ASSERT_TRUE(GrabFrames(5));
  for (int i = 0; i < 3; ++i) {
    Fault(SimFault::Kind::kStampBack, i == 2 ? 0.3 : 0.0);
    ASSERT_TRUE(GrabFrames(12));
  }
  EXPECT_GT(camera_->status().num_clock_steps, 0);
  EXPECT_EQ(camera_->status().num_bad, 0);
  for (const CameraFrame& frame : frames_) EXPECT_EQ(frame.depth_mm.size(), 640U * 480U);
}

}  // namespace
}  // namespace vantage
