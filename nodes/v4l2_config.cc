#include "nodes/v4l2_config.h"

#include <string>
#include <utility>
#include <vector>

#include "drivers/v4l2/pixel_format.h"

namespace vantage {
namespace {

void ReadColorDevice(ConfigReader::Table& table, V4l2Config* config) {
  std::string text;
  table.Read("color_device", &text);
  if (text.empty()) return;
  const Result<DeviceSelector> selector = DeviceSelector::Parse(text);
  if (!selector || selector->kind == DeviceSelector::Kind::kRecording) {
    table.Fail("color_device", selector ? "expected no recording" : selector.error().message);
  } else if (!config->camera.stream.color) {
    table.Fail("color_device", "expected color = true beside it");
  } else {
    config->v4l2.color_device = *selector;
  }
}

}  // namespace

Result<V4l2Config> ReadV4l2Config(ConfigReader& config, const std::string& process_name) {
  Result<CameraConfig> camera = ReadCameraConfig(config, process_name, "v4l2");
  if (!camera) return camera.error();
  V4l2Config result{std::move(*camera), {}};
  ConfigReader::Table table = config.Root().Sub("camera").Sub(result.camera.name);
  if (result.camera.device.kind == DeviceSelector::Kind::kRecording) {
    table.Fail("device", "expected no recording: those are read by vantage-openni2");
  }
  std::vector<std::string> formats = PixelFormatNames();
  formats.insert(formats.begin(), "auto");
  table.ReadChoice("pixel_format", &result.v4l2.pixel_format, formats);
  table.Read("depth_unit_um", &result.v4l2.depth_unit_um, 1, 1'000'000);
  ReadColorDevice(table, &result);
  ConfigReader::Table disparity = table.Sub("disparity");
  DisparityModel& model = result.v4l2.disparity;
  disparity.Read("baseline_mm", &model.baseline_mm, 1.0, 1000.0);
  disparity.Read("focal_px", &model.focal_px, 1.0, 1e5);
  disparity.Read("offset", &model.offset, 1.0, 1e5);
  disparity.Read("steps_per_px", &model.steps_per_px, 1.0, 64.0);
  return result;
}

}  // namespace vantage
