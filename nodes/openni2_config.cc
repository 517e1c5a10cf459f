#include "nodes/openni2_config.h"

#include <utility>

namespace vantage {

Result<Openni2Config> ReadOpenni2Config(ConfigReader& config, const std::string& process_name) {
  Result<CameraConfig> camera = ReadCameraConfig(config, process_name, "openni2");
  if (!camera) return camera.error();
  Openni2Config result{std::move(*camera), {}};
  ConfigReader::Table table = config.Root().Sub("camera").Sub(result.camera.name);
  if (result.camera.stream.color && result.camera.stream.color_layout == PixelLayout::kJpeg) {
    table.Fail("color_encoding", "expected \"rgb\" or \"gray\": OpenNI2 gives no JPEG images");
  }
  table.ReadPath("record_oni", &result.record_file);
  if (!result.record_file.empty() &&
      result.camera.device.kind == DeviceSelector::Kind::kRecording) {
    table.Fail("record_oni", "expected none beside a device that is a recording itself");
  }
  return result;
}

}  // namespace vantage
