#include "nodes/v4l2_node.h"

#include "drivers/v4l2/device_report.h"
#include "drivers/v4l2/v4l2_api.h"
#include "nodes/camera_node.h"
#include "nodes/v4l2_config.h"

namespace vantage {

Result<std::unique_ptr<Node>> MakeV4l2Node(Bus& bus,
                                           ConfigReader& config,
                                           const ProcessOptions& options) {
  const Result<V4l2Config> read = ReadV4l2Config(config, options.name);
  if (!read) return read.error();
  IgnoreTablesOfOthers(config);
  // Before any hardware is touched.
  if (Result<void> finished = config.Finish(); !finished) return finished.error();
  return MakeCameraNode(
      bus, read->camera, options.name, std::make_unique<V4l2Api>(read->v4l2, read->camera.device));
}

Result<std::string> ListV4l2Devices() { return ReportVideoDevices({}); }

}  // namespace vantage
