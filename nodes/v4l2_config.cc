#include "nodes/v4l2_config.h"

#include <utility>

#include "common/format.h"
#include "drivers/v4l2/pixel_format.h"

namespace vantage {

Result<V4l2Config> ReadV4l2Config(ConfigReader& config, const std::string& process_name) {
  Result<CameraConfig> camera = ReadCameraConfig(config, process_name, "v4l2");
  if (!camera) return camera.error();
  V4l2Config result{std::move(*camera), {}};
  ConfigReader::Table table = config.Root().Sub("camera").Sub(result.camera.name);
  if (result.camera.device.kind == DeviceSelector::Kind::kRecording) {
    table.Fail("device", "expected no recording: those are read by vantage-openni2");
  }
  table.Read("pixel_format", &result.v4l2.pixel_format);
  if (result.v4l2.pixel_format != "auto" && FindPixelFormat(result.v4l2.pixel_format) == nullptr) {
    table.Fail("pixel_format", "expected \"auto\" or one of " + PixelFormatNames());
  }
  table.Read("depth_unit_um", &result.v4l2.depth_unit_um, 1, 1'000'000);
  ConfigReader::Table disparity = table.Sub("disparity");
  DisparityModel& model = result.v4l2.disparity;
  disparity.Read("baseline_mm", &model.baseline_mm, 1.0, 1000.0);
  disparity.Read("focal_px", &model.focal_px, 1.0, 1e5);
  disparity.Read("offset", &model.offset, 1.0, 1e5);
  disparity.Read("steps_per_px", &model.steps_per_px, 1.0, 64.0);
  return result;
}

}  // namespace vantage
