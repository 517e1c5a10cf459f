#pragma once

#include <memory>

#include "bus/bus.h"
#include "common/result.h"
#include "nodes/config_reader.h"
#include "nodes/fusion_config.h"
#include "nodes/node.h"
#include "nodes/process.h"

namespace vantage {

/// vantage-fusion: fuses what comes on DETECTIONS_<NAME> into OBJECTS and ORIENTATION_HISTOGRAM,
/// and leads the camera by NEXT_VIEW, which it repeats every second of message time (same seq). Of
/// ARM_STATUS it learns refusals. Its clock is that of the messages.
/// Errors: the config; a model that can't be loaded; a state file that can't be moved aside.
Result<std::unique_ptr<Node>> MakeFusionNode(Bus& bus,
                                             ConfigReader& config,
                                             const ProcessOptions& options);

/// The same from a config that is at hand. @param fresh a saved state is deleted.
Result<std::unique_ptr<Node>> MakeFusionNode(Bus& bus, const FusionConfig& config, bool fresh);

}  // namespace vantage
