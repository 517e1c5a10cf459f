#include "nodes/openni2_node.h"

#include "common/format.h"
#include "drivers/openni2/openni2_api.h"
#include "nodes/camera_config.h"
#include "nodes/camera_node.h"

namespace vantage {
namespace {

// What other drivers can do and OpenNI2 can't.
Result<void> CheckPossible(const CameraConfig& camera, const RecordTarget& record) {
  if (camera.stream.color && camera.stream.color_layout == PixelLayout::kJpeg) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("[camera.%s] color_encoding = \"mjpeg\": OpenNI2 gives no JPEG images, "
                        "expected \"rgb\" or \"gray\"",
                        camera.name.c_str())};
  }
  if (camera.device.kind == DeviceSelector::Kind::kRecording && !record.file.empty()) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("[camera.%s] record_oni beside a device that is a recording itself, "
                        "expected one or the other",
                        camera.name.c_str())};
  }
  return {};
}

}  // namespace

Result<std::unique_ptr<Node>> MakeOpenni2Node(Bus& bus,
                                              ConfigReader& config,
                                              const ProcessOptions& options) {
  const Result<CameraConfig> camera = ReadCameraConfig(config, options.name, "openni2");
  if (!camera) return camera.error();
  RecordTarget record;
  config.Root().Sub("camera").Sub(camera->name).ReadPath("record_oni", &record.file);
  IgnoreTablesOfOthers(config);
  // Before any hardware is touched.
  if (Result<void> read = config.Finish(); !read) return read.error();
  if (Result<void> possible = CheckPossible(*camera, record); !possible) return possible.error();
  Result<std::unique_ptr<Openni2Api>> api = Openni2Api::Create(std::move(record));
  if (!api) return api.error();
  return MakeCameraNode(bus, *camera, options.name, std::move(api).value());
}

Result<std::string> ListOpenni2Devices() {
  Result<std::unique_ptr<Openni2Api>> api = Openni2Api::Create();
  if (!api) return api.error();
  return (*api)->Describe();
}

}  // namespace vantage
