#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/monitor/monitor_model.h"
#include "tools/monitor/monitor_screen.h"

namespace vantage {

/// The parts that screen and snapshot are made of. Lines are as long as they become; a table's
/// first line is its heading.

/// "vantage-top  12:34:56  5 processes, ...  URL".
ScreenLine TitleLine(const MonitorModel& model, const std::string& where, int64_t now);
/// One line a process, in the order of their names.
std::vector<ScreenLine> ProcessTable(const MonitorModel& model, int64_t now);
/// Who a process is, its channels and its stages.
std::vector<ScreenLine> ProcessDetails(const MonitorModel& model,
                                       const SeenProcess& process,
                                       int64_t now);
std::vector<ScreenLine> CameraTable(const MonitorModel& model, int64_t now);
/// Arms and hand-eye checks, a line each; no heading.
std::vector<ScreenLine> ArmLines(const MonitorModel& model, int64_t now);
std::vector<ScreenLine> ChannelTable(const MonitorModel& model, ChannelOrder order, int64_t now);

const char* OrderName(ChannelOrder order);

}  // namespace vantage
