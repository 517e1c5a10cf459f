#include "nodes/v4l2_config.h"

#include <gtest/gtest.h>

#include "nodes/process.h"

namespace vantage {
namespace {

// The config, or the sentence that says why not.
struct Outcome {
  V4l2Config config;
  std::string error;
};

Outcome Read(const std::string& text, const std::string& process_name = "v4l2") {
  Result<ConfigReader> reader = ConfigReader::Parse(text, "x.toml");
  if (!reader) return {{}, reader.error().message};
  const Result<V4l2Config> config = ReadV4l2Config(*reader, process_name);
  if (!config) return {{}, config.error().message};
  IgnoreTablesOfOthers(*reader);
  const Result<void> finished = reader->Finish();
  return {*config, finished ? std::string() : finished.error().message};
}

const std::string kCamera = "[camera.KINECT]\ndriver = \"v4l2\"\ndevice = \"path:/dev/video2\"\n";

TEST(V4l2Config, DefaultsTakeWhatADeviceHas) {
  const Outcome read = Read(kCamera);
  ASSERT_EQ(read.error, "");
  EXPECT_EQ(read.config.camera.name, "KINECT");
  EXPECT_EQ(read.config.camera.device.Text(), "path:/dev/video2");
  EXPECT_EQ(read.config.v4l2.pixel_format, "auto");
  EXPECT_EQ(read.config.v4l2.depth_unit_um, 1000);
  EXPECT_TRUE(read.config.v4l2.disparity.Validate().ok());
}

TEST(V4l2Config, ReadsFormatUnitAndDisparity) {
  const Outcome read = Read(kCamera +
                            "pixel_format = \"Y10B\"\n"
                            "depth_unit_um = 125\n"
                            "[camera.KINECT.controls]\n"
                            "gain = 4\n"
                            "[camera.KINECT.disparity]\n"
                            "baseline_mm = 74.5\n"
                            "focal_px = 590.0\n"
                            "offset = 1084.5\n"
                            "steps_per_px = 4\n");
  ASSERT_EQ(read.error, "");
  EXPECT_EQ(read.config.v4l2.pixel_format, "Y10B");
  EXPECT_EQ(read.config.v4l2.depth_unit_um, 125);
  EXPECT_EQ(read.config.camera.controls, (std::map<std::string, int64_t>{{"gain", 4}}));
  EXPECT_EQ(read.config.v4l2.disparity.baseline_mm, 74.5);
  EXPECT_EQ(read.config.v4l2.disparity.focal_px, 590.0);
  EXPECT_EQ(read.config.v4l2.disparity.offset, 1084.5);
  EXPECT_EQ(read.config.v4l2.disparity.steps_per_px, 4.0);
}

TEST(V4l2Config, ReadsTheColorsDevice) {
  EXPECT_FALSE(Read(kCamera).config.v4l2.color_device.has_value());
  const Outcome read = Read(kCamera + "color = true\ncolor_device = \"serial:123\"\n");
  ASSERT_EQ(read.error, "");
  EXPECT_EQ(read.config.v4l2.color_device->Text(), "serial:123");
}

TEST(V4l2Config, EveryDevicesKindIsRead) {
  for (const char* device :
       {"index:0", "serial:123", "uri:/dev/video0", "id:usb-x", "bus:usb-0000:00:14.0-2"}) {
    const std::string text =
        "[camera.A]\ndriver = \"v4l2\"\ndevice = \"" + std::string(device) + "\"\n";
    EXPECT_EQ(Read(text).error, "") << device;
  }
}

TEST(V4l2Config, ProcessNameChoosesAmongCamerasOfV4l2) {
  const std::string text =
      "[camera.A]\ndevice = \"index:0\"\n"
      "[camera.B]\ndriver = \"v4l2\"\ndevice = \"index:0\"\n"
      "[camera.C]\ndriver = \"v4l2\"\ndevice = \"index:1\"\npixel_format = \"GREY\"\n";
  EXPECT_EQ(Read(text).config.camera.name, "B");
  EXPECT_EQ(Read(text, "v4l2-c").config.camera.name, "C");
  EXPECT_EQ(Read(text, "v4l2-c").config.v4l2.pixel_format, "GREY");
  EXPECT_NE(Read(text, "v4l2-a").error, "");
  EXPECT_NE(Read("[camera.A]\ndevice = \"index:0\"\n").error, "");
}

TEST(V4l2Config, RefusesWhatIsOutOfRange) {
  for (const char* line : {"pixel_format = \"H264\"",
                           "pixel_format = 3",
                           "depth_unit_um = 0",
                           "depth_unit_um = 1000001",
                           "depth_unit_um = nan",
                           "disparity = { offset = -1.0 }",
                           "disparity = { offset = inf }",
                           "disparity = { baseline_mm = 0 }",
                           "disparity = { focal = 580.0 }",
                           "color_device = \"id:x\"",
                           "color = true\ncolor_device = \"x\"",
                           "color = true\ncolor_device = \"oni:x.oni\"",
                           "unknown = 1"}) {
    EXPECT_NE(Read(kCamera + line + "\n").error, "") << line;
  }
  EXPECT_EQ(Read("[camera.A]\ndriver = \"v4l2\"\ndevice = \"oni:x.oni\"\n").error,
            "x.toml:3: camera.A.device = 'oni:x.oni': expected no recording: those are read by "
            "vantage-openni2");
}

TEST(V4l2Config, KeysOfV4l2AreUnknownToOtherDrivers) {
  Result<ConfigReader> reader =
      ConfigReader::Parse("[camera.A]\ndevice = \"index:0\"\npixel_format = \"Z16\"\n", "x.toml");
  ASSERT_TRUE(reader.ok());
  ASSERT_TRUE(ReadCameraConfig(*reader, "openni2", "openni2").ok());
  EXPECT_FALSE(reader->Finish().ok());
}

}  // namespace
}  // namespace vantage
