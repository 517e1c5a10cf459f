// Devices that differ in what they can do.
#include <gtest/gtest.h>

#include <array>
#include <ostream>
#include <string>
#include <vector>

#include "tests/drivers/openni2_plugin/openni2_fixture.h"

namespace vantage {

// Names of the tests that take one.
static void PrintTo(SimAbilities::Registration registration, std::ostream* out) {
  *out << std::array{"Works", "Claimed", "None"}.at(static_cast<size_t>(registration));
}
static void PrintTo(SimAbilities::Mirroring mirroring, std::ostream* out) {
  *out << std::array{"Off", "On", "Always", "AlwaysDepth"}.at(static_cast<size_t>(mirroring));
}

namespace {

TEST_F(Openni2Plugin, TellsWhatADeviceCanDo) {
  Result<std::unique_ptr<Openni2Api>> api = Openni2Api::Create();
  ASSERT_TRUE(api.ok()) << api.error().message;
  SimAbilities abilities;
  abilities.infrared = true;
  abilities.mirroring = SimAbilities::Mirroring::kAlways;
  SetAbilities(abilities);
  const std::string text = (*api)->Describe();
  for (const std::string& line :
       {"uri:vantage-sim://" + std::string(kTestSerial) + "  Vantage Simulated Xtion\n",
        "  serial:" + std::string(kTestSerial) + "\n",
        std::string("  depth: 640x480 at 30 Hz in 1 mm, 320x240 at 30 Hz in 1 mm\n"),
        std::string("  color: 640x480 at 30 Hz in RGB, 320x240 at 30 Hz in RGB\n"),
        std::string("  infrared: 640x480 at 30 Hz in 16 bit gray, "),
        std::string("  registers depth to color: yes, it says\n"),
        std::string("  mirrored: always; turned here\n")}) {
    EXPECT_NE(text.find(line), std::string::npos) << line << "not in\n" << text;
  }
}

TEST_F(Openni2Plugin, DepthInTenthsOfAMillimetre) {
  abilities_.fine_depth = true;
  Create("index:0");
  ASSERT_TRUE(GrabFrames(1)) << camera_->status().message;
  EXPECT_EQ(frames_.back().depth_mm, ExpectedImages().Depth());
}

class Openni2Registration : public Openni2Plugin,
                            public ::testing::WithParamInterface<SimAbilities::Registration> {};

// OpenNI2 says OK in each case: only the mode that is read back tells. What the device does not
// do is no error; whoever has calibrated extrinsics does it afterwards.
TEST_P(Openni2Registration, IsReadBackAlsoAfterAReconnect) {
  abilities_.registration = GetParam();
  const bool works = GetParam() == SimAbilities::Registration::kWorks;
  options_.stream.color = true;
  options_.stream.registration = Registration::kDepthToColor;
  Create("index:0");
  ASSERT_TRUE(GrabFrames(2)) << camera_->status().message;
  EXPECT_EQ(frames_.back().registered, works);
  Fault(SimFault::Kind::kUnplug);
  ASSERT_TRUE(GrabUntil([this] { return camera_->status().state == CameraState::kSearching; }));
  Fault(SimFault::Kind::kReplug);
  ASSERT_TRUE(GrabUntil([this] { return camera_->status().num_reconnects == 1; }));
  ASSERT_TRUE(GrabFrames(2));
  EXPECT_EQ(frames_.back().registered, works);
  EXPECT_EQ(camera_->status().state, CameraState::kStreaming);
}

INSTANTIATE_TEST_SUITE_P(Devices,
                         Openni2Registration,
                         ::testing::Values(SimAbilities::Registration::kWorks,
                                           SimAbilities::Registration::kClaimed,
                                           SimAbilities::Registration::kNone));

class Openni2Mirroring : public Openni2Plugin,
                         public ::testing::WithParamInterface<SimAbilities::Mirroring> {};

TEST_P(Openni2Mirroring, ImagesRunFromLeftToRight) {
  abilities_.mirroring = GetParam();
  options_.stream.color = true;
  Create("index:0");
  ASSERT_TRUE(GrabUntil([this] { return !frames_.empty() && frames_.back().color; }));
  ExpectedImages expected;
  EXPECT_EQ(frames_.back().depth_mm, expected.Depth());
  EXPECT_EQ(frames_.back().color->data, expected.Color());
  // The field of view puts the principal point into the middle, which is its own mirror image.
  EXPECT_EQ(frames_.back().model->cx, 319.5);
}

INSTANTIATE_TEST_SUITE_P(Devices,
                         Openni2Mirroring,
                         ::testing::Values(SimAbilities::Mirroring::kOff,
                                           SimAbilities::Mirroring::kOn,
                                           SimAbilities::Mirroring::kAlways,
                                           SimAbilities::Mirroring::kAlwaysDepth));

}  // namespace
}  // namespace vantage
