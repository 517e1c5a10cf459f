#pragma once

#include <memory>
#include <string>

#include "bus/bus.h"
#include "common/result.h"
#include "nodes/config_reader.h"
#include "nodes/node.h"
#include "nodes/process.h"

namespace vantage {

/// vantage-openni2: a camera node on OpenNI2's devices.
/// Errors: the config; a recording that is absent or none; a file to record to that exists; OpenNI2
/// without drivers.
Result<std::unique_ptr<Node>> MakeOpenni2Node(Bus& bus,
                                              ConfigReader& config,
                                              const ProcessOptions& options);

/// What `vantage-openni2 --list` prints: the devices that OpenNI2 finds and what they can do.
/// Errors: OpenNI2 without drivers.
Result<std::string> ListOpenni2Devices();

}  // namespace vantage
