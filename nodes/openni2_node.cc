#include "nodes/openni2_node.h"

#include "drivers/openni2/openni2_api.h"
#include "nodes/camera_node.h"
#include "nodes/openni2_config.h"

namespace vantage {

Result<std::unique_ptr<Node>> MakeOpenni2Node(Bus& bus,
                                              ConfigReader& config,
                                              const ProcessOptions& options) {
  const Result<Openni2Config> openni2 = ReadOpenni2Config(config, options.name);
  if (!openni2) return openni2.error();
  IgnoreTablesOfOthers(config);
  // Before any hardware is touched.
  if (Result<void> read = config.Finish(); !read) return read.error();
  Result<std::unique_ptr<Openni2Api>> api = Openni2Api::Create({.file = openni2->record_file});
  if (!api) return api.error();
  return MakeCameraNode(bus, openni2->camera, options.name, std::move(api).value());
}

Result<std::string> ListOpenni2Devices() {
  Result<std::unique_ptr<Openni2Api>> api = Openni2Api::Create();
  if (!api) return api.error();
  return (*api)->Describe();
}

}  // namespace vantage
