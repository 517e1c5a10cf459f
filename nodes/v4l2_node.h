#pragma once

#include <memory>
#include <string>

#include "bus/bus.h"
#include "common/result.h"
#include "nodes/config_reader.h"
#include "nodes/node.h"
#include "nodes/process.h"

namespace vantage {

/// vantage-v4l2: a camera node on the kernel's video devices. Errors: the config.
Result<std::unique_ptr<Node>> MakeV4l2Node(Bus& bus,
                                           ConfigReader& config,
                                           const ProcessOptions& options);

/// What `vantage-v4l2 --list` prints: every video device with what it can do.
Result<std::string> ListV4l2Devices();

}  // namespace vantage
