#pragma once

#include <memory>

#include "bus/bus.h"
#include "common/result.h"
#include "drivers/openni2/depth_device.h"
#include "nodes/config_reader.h"
#include "nodes/node.h"
#include "nodes/openni2_config.h"
#include "nodes/process.h"

namespace vantage {

/// vantage-openni2: a depth camera on CAMERA_<NAME>, CAMERA_<NAME>_INFO and CAMERA_<NAME>_STATUS;
/// obeys CAMERA_<NAME>_COMMAND. Without a device it searches until one comes.
/// Errors: the config; a recording that is absent or none; OpenNI2 without drivers.
Result<std::unique_ptr<Node>> MakeOpenni2Node(Bus& bus,
                                              ConfigReader& config,
                                              const ProcessOptions& options);

/// The same on devices that are handed in. The node calls `bus` from threads of its own, so it must
/// be one whose Publish, RecordStage and NowUtime are safe from any thread, and outlive the node.
Result<std::unique_ptr<Node>> MakeOpenni2Node(Bus& bus,
                                              const Openni2Config& config,
                                              const std::string& process_name,
                                              std::unique_ptr<DepthDeviceApi> api);

}  // namespace vantage
