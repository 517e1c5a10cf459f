#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/monitor/monitor_model.h"

namespace vantage {

/// All that is known, for scripts: {"ok", "problems", "processes", "cameras", "arms", "hand_eye",
/// "channels"}; SI units, names as in the messages. Numbers that are not finite are null, bytes
/// that are no UTF-8 are replaced.
std::string MonitorJson(const MonitorModel& model,
                        const std::vector<std::string>& problems,
                        int64_t now);

}  // namespace vantage
