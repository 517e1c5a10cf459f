#include "nodes/camera_config.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "common/format.h"
#include "nodes/process.h"

namespace vantage {
namespace {

// The config, or the sentence that says why not.
struct Outcome {
  CameraConfig config;
  std::string error;
};

Outcome Read(const std::string& text, const std::string& process_name = "openni2") {
  Result<ConfigReader> reader = ConfigReader::Parse(text, "x.toml");
  if (!reader) return {{}, reader.error().message};
  const Result<CameraConfig> config = ReadCameraConfig(*reader, process_name, "openni2");
  if (!config) return {{}, config.error().message};
  IgnoreTablesOfOthers(*reader);
  const Result<void> finished = reader->Finish();
  return {*config, finished ? std::string() : finished.error().message};
}

class CalibrationFile {
 public:
  explicit CalibrationFile(const std::string& text) { std::ofstream(path_) << text; }
  ~CalibrationFile() { std::filesystem::remove(path_); }
  CalibrationFile(const CalibrationFile&) = delete;
  CalibrationFile& operator=(const CalibrationFile&) = delete;
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_ = testing::TempDir() + Format("camera_config_test.%d.toml", getpid());
};

const char* const kCalibration =
    "width_px = 640\nheight_px = 480\nfx_px = 570.0\nfy_px = 571.0\ncx_px = 319.0\ncy_px = 240.0\n";

TEST(CameraConfig, DefaultsSuitAnXtion) {
  const Outcome read = Read("[camera.XTION]\ndevice = \"index:0\"\n");
  ASSERT_EQ(read.error, "");
  EXPECT_EQ(read.config.name, "XTION");
  EXPECT_EQ(read.config.stream.width, 640);
  EXPECT_EQ(read.config.stream.fps, 30);
  EXPECT_EQ(read.config.rate_hz, 10.0);
  EXPECT_EQ(read.config.compression, DepthCompression::kVdc);
  EXPECT_FALSE(read.config.calibration.has_value());
}

TEST(CameraConfig, TheDemosConfigIsRead) {
  Result<ConfigReader> reader = ConfigReader::Open(VANTAGE_SOURCE_DIR "/config/demo.toml");
  ASSERT_TRUE(reader.ok());
  const Result<CameraConfig> config = ReadCameraConfig(*reader, "openni2", "openni2");
  ASSERT_TRUE(config.ok());
  EXPECT_EQ(config->device.Text(), "serial:SIM0001");
  IgnoreTablesOfOthers(*reader);
  EXPECT_TRUE(reader->Finish().ok());
}

TEST(CameraConfig, ProcessNameChoosesTheCamera) {
  const std::string two =
      "[camera.LEFT]\ndevice = \"index:0\"\n[camera.RIGHT]\ndevice = \"index:1\"\nother = 1\n";
  EXPECT_EQ(Read(two).config.name, "LEFT");
  EXPECT_EQ(Read(two).error, "");
  EXPECT_EQ(Read(two, "openni2-right").config.name, "RIGHT");
  EXPECT_NE(Read(two, "openni2-right").error.find("camera.RIGHT.other"), std::string::npos);
  EXPECT_EQ(Read(two, "openni2-top").error,
            "the process name openni2-top belongs to no [camera.<NAME>] of the config, expected "
            "one of: openni2-left, openni2-right");
}

TEST(CameraConfig, WhereTheDriverHasNoCameraThoseOfOthersAreTold) {
  const std::string text = "[camera.A]\ndevice = \"index:0\"\ndriver = \"v4l2\"\n";
  EXPECT_NE(Read(text).error.find("; [camera.A] has driver = \"v4l2\""), std::string::npos)
      << Read(text).error;
  EXPECT_NE(Read("[camera.A]\ndevice = \"index:0\"\ndriver = \"v4l3\"\n")
                .error.find("camera.A.driver = 'v4l3': expected one of \"openni2\" \"v4l2\""),
            std::string::npos);
}

TEST(CameraConfig, ErrorsNameTheKeyAndTheBound) {
  const std::string camera = "[camera.XTION]\n";
  const std::string device = camera + "device = \"index:0\"\n";
  const struct {
    std::string text;
    std::string expected;
  } cases[] = {
      {"", "the config has no [camera.<NAME>]"},
      {"[camera.xtion]\ndevice = \"index:0\"\n", "[camera.xtion]: expected a name of"},
      {camera, "camera.XTION.device"},
      {camera + "device = \"first\"\n", "expected \"index:N\""},
      {device + "fsp = 30\n", "camera.XTION.fsp = 30: unknown key"},
      {device + "fps = 0\n", "camera.XTION.fps = 0: expected a number from 1 to 1000"},
      {device + "width_px = 100000\n", "camera.XTION.width_px = 100000"},
      {device + "rate_hz = -1.0\n", "camera.XTION.rate_hz"},
      {device + "stall_timeout_s = 0.0\n", "camera.XTION.stall_timeout_s"},
      {device + "compression = \"png\"\n", "expected one of \"vdc\" \"zlib\" \"none\""},
      {device + "color = 1\n", "expected true or false"},
      {device + "calibration = \"/no/such.toml\"\n", "calibration file /no/such.toml is not there"},
  };
  for (const auto& each : cases) {
    EXPECT_NE(Read(each.text).error.find(each.expected), std::string::npos)
        << each.text << " gave: " << Read(each.text).error;
  }
}

TEST(CameraConfig, ARecordingsPathStartsAtTheConfigsFolder) {
  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / Format("camera_config_test.%d", getpid());
  std::filesystem::create_directories(folder);
  const auto device_of = [&folder](const std::string& device) {
    std::ofstream(folder / "x.toml") << "[camera.XTION]\ndevice = \"" << device << "\"\n";
    Result<ConfigReader> reader = ConfigReader::Open(folder / "x.toml");
    return ReadCameraConfig(*reader, "openni2", "openni2")->device.Text();
  };
  EXPECT_EQ(device_of("oni:../run.oni"), "oni:" + (folder.parent_path() / "run.oni").string());
  EXPECT_EQ(device_of("oni:/a/run.oni"), "oni:/a/run.oni");
  EXPECT_EQ(device_of("serial:run.oni"), "serial:run.oni");
  std::filesystem::remove_all(folder);
}

TEST(CameraConfig, ACalibrationOfAnotherSizeIsRefused) {
  const CalibrationFile file(kCalibration);
  const std::string text = "[camera.XTION]\nwidth_px = 320\nheight_px = 240\ncalibration = \"" +
                           file.path() + "\"\ndevice = ";
  EXPECT_NE(Read(text + "\"index:0\"\n").error.find("is for 640 x 480 px, expected the 320 x 240"),
            std::string::npos);
  const Outcome fits =
      Read("[camera.XTION]\ndevice = \"index:0\"\ncalibration = \"" + file.path() + "\"\n");
  ASSERT_EQ(fits.error, "");
  ASSERT_TRUE(fits.config.calibration.has_value());
  EXPECT_EQ(fits.config.calibration->intrinsics.camera.fy, 571.0);
  // A recording has the size that it has.
  EXPECT_EQ(Read(text + "\"oni:x.oni\"\n").error, "");
}

}  // namespace
}  // namespace vantage
