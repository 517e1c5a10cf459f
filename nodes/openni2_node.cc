#include "nodes/openni2_node.h"

#include "common/format.h"
#include "drivers/openni2/openni2_api.h"
#include "nodes/camera_config.h"
#include "nodes/camera_node.h"

namespace vantage {

Result<std::unique_ptr<Node>> MakeOpenni2Node(Bus& bus,
                                              ConfigReader& config,
                                              const ProcessOptions& options) {
  const Result<CameraConfig> camera = ReadCameraConfig(config, options.name, "openni2");
  if (!camera) return camera.error();
  IgnoreTablesOfOthers(config);
  // Before any hardware is touched.
  if (Result<void> read = config.Finish(); !read) return read.error();
  Result<std::unique_ptr<Openni2Api>> api = Openni2Api::Create();
  if (!api) return api.error();
  return MakeCameraNode(bus, *camera, options.name, std::move(api).value());
}

Result<std::string> ListOpenni2Devices() {
  Result<std::unique_ptr<Openni2Api>> api = Openni2Api::Create();
  if (!api) return api.error();
  std::string list;
  for (const DeviceListing& device : (*api)->List()) {
    list += Format("uri:%s  %s\n", device.uri.c_str(), device.name.c_str());
  }
  if (list.empty()) list = "no OpenNI2 device; " + (*api)->search_hint() + "\n";
  return list;
}

}  // namespace vantage
