// The settings of a device: by name, refused in a sentence, read back where the device keeps them.
#include <gtest/gtest.h>

#include "tests/drivers/v4l2_live/emulated_devices.h"
#include "tests/drivers/v4l2_live/live_camera.h"

namespace vantage {
namespace {

class Controls : public testing::Test {
 protected:
  void SetUp() override {
    devices_.Describe(DeviceZero(SmallFormat("YUYV") +
                                 "control brightness 0 255 1 128\n"
                                 "control gain 0 100 5 10\n"
                                 "control power_line_frequency 0 2 1 1\n"
                                 "control white_balance_automatic 0 1 1 1\n"
                                 "control white_balance_temperature 2800 6500 10 4600\n"
                                 "control auto_exposure 0 3 1 3\n"
                                 "control exposure_time_absolute 3 2047 1 250\n"));
    ASSERT_TRUE(live_.GrabFrames(1)) << live_.Summary();
  }
  // "": it was done.
  std::string Set(const std::string& name, int64_t value) {
    const Result<void> done = live_.camera().SetControl(name, value);
    return done ? "" : done.error().message;
  }
  std::optional<int64_t> Get(const std::string& name) { return devices_.Control(0, name); }

  EmulatedDevices devices_;
  LiveCamera live_;
};

TEST_F(Controls, AreSetByName) {
  EXPECT_EQ(Set("brightness", 77), "");
  EXPECT_EQ(Get("brightness"), 77);
  EXPECT_EQ(Set("power_line_frequency", 2), "");
  EXPECT_EQ(Get("power_line_frequency"), 2);
  EXPECT_EQ(Set("white_balance_automatic", 0), "");
  EXPECT_EQ(Set("white_balance_temperature", 3000), "");
  EXPECT_EQ(Get("white_balance_temperature"), 3000);
  EXPECT_TRUE(live_.GrabFrames(3)) << live_.Summary();
}

TEST_F(Controls, ThatThereAreNotAreToldWithThoseThatThereAre) {
  EXPECT_EQ(Set("warp_factor", 9),
            "device /dev/video0 has no control warp_factor, expected one of: brightness, "
            "white_balance_automatic, gain, power_line_frequency, white_balance_temperature, "
            "auto_exposure, exposure_time_absolute");
}

TEST_F(Controls, ValuesThatAreNotTakenAreToldWithThoseThatAre) {
  EXPECT_NE(Set("brightness", 256).find("expected 0 to 255"), std::string::npos);
  EXPECT_NE(Set("brightness", INT64_MIN).find("expected 0 to 255"), std::string::npos);
  EXPECT_NE(Set("gain", 12).find("0 to 100 in steps of 5"), std::string::npos);
  EXPECT_NE(Set("power_line_frequency", 3).find("0 (Disabled), 1 (50 Hz), 2 (60 Hz)"),
            std::string::npos);
  EXPECT_EQ(Get("brightness"), 128);  // Nothing was set.
}

TEST_F(Controls, InTheHandOfAnAutomaticOneAreRefused) {
  EXPECT_NE(Set("white_balance_temperature", 3000).find("an automatic one, has it in hand"),
            std::string::npos);
  EXPECT_EQ(Get("white_balance_temperature"), 4600);
}

TEST_F(Controls, ExposureTakesItFromTheAutomatic) {
  ASSERT_TRUE(live_.camera().SetExposure(10'000).ok());
  EXPECT_EQ(Get("exposure_time_absolute"), 100);  // In units of 100 us.
  EXPECT_EQ(Get("auto_exposure"), 1);             // Manual.
  ASSERT_TRUE(live_.camera().SetExposure(0).ok());
  EXPECT_NE(Get("auto_exposure"), 1);
  const Result<void> refused = live_.camera().SetExposure(1'000'000);
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().message.find("expected 300 to 204700 us"), std::string::npos)
      << refused.error().message;
  ASSERT_TRUE(live_.camera().SetGain(25).ok());
  EXPECT_EQ(Get("gain"), 25);
}

TEST_F(Controls, OfADeviceThatRefusesAreTold) {
  devices_.Describe(
      DeviceZero(SmallFormat("YUYV") + "control brightness 0 255 1 128\nfail S_EXT_CTRLS EIO 1\n"));
  EXPECT_NE(Set("brightness", 77).find("refuses brightness = 77"), std::string::npos);
  EXPECT_EQ(Set("brightness", 77), "");
  EXPECT_EQ(Get("brightness"), 77);
}

TEST(NoControls, AreToldToBeNone) {
  const EmulatedDevices devices;
  devices.Describe(DeviceZero(SmallFormat("YUYV")));
  LiveCamera live;
  ASSERT_TRUE(live.GrabFrames(1)) << live.Summary();
  const Result<void> refused = live.camera().SetControl("gain", 1);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().message,
            "device /dev/video0 has no control gain, expected one of: none");
  EXPECT_FALSE(live.camera().SetExposure(1000).ok());
  EXPECT_FALSE(live.camera().SetGain(1).ok());
}

}  // namespace
}  // namespace vantage
