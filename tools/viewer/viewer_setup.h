#pragma once

#include <string>
#include <vector>

#include "bus/live_bus.h"
#include "common/result.h"
#include "tools/viewer/viewer_scene.h"

namespace vantage {

/// What the viewer takes from a configuration.
struct ViewerSetup {
  ModelMap models;            ///< of [models]
  double table_height = 0.0;  ///< m, [planner]
  LiveBus::Options bus;       ///< [bus]
  std::string warning;        ///< why something of it is not there; empty: all is
};

/// Of a file; without one, of the log's LOG_HEADER. A log without one, or whose models are not on
/// this machine, can be shown all the same: that is a warning. Errors: a file that is named and
/// can't be read.
Result<ViewerSetup> LoadViewerSetup(const std::string& config_file, const std::string& log);

}  // namespace vantage
