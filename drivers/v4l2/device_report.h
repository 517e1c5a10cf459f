#pragma once

#include <string>

#include "drivers/v4l2/video_node.h"

namespace vantage {

/// Every video device of this host with its names, formats, sizes, rates and controls, for people
/// to read. What can't be opened is listed with the reason.
std::string ReportVideoDevices(const VideoRoots& roots);

}  // namespace vantage
