#pragma once

#include <memory>

#include "bus/bus.h"
#include "common/result.h"
#include "drivers/camera/camera_device.h"
#include "nodes/camera_config.h"
#include "nodes/node.h"

namespace vantage {

/// A camera on CAMERA_<NAME>, CAMERA_<NAME>_INFO and CAMERA_<NAME>_STATUS, whatever its driver;
/// obeys CAMERA_<NAME>_COMMAND. Without a device it searches until one comes. The node calls `bus`
/// from threads of its own, so it must be one whose Publish, RecordStage and NowUtime are safe from
/// any thread, and outlive the node.
/// Errors: a recording that is absent or none.
Result<std::unique_ptr<Node>> MakeCameraNode(Bus& bus,
                                             const CameraConfig& config,
                                             const std::string& process_name,
                                             std::unique_ptr<CameraDeviceApi> api);

}  // namespace vantage
