#pragma once

#include <OpenNI.h>

#include <optional>
#include <string>

#include "drivers/camera/camera_device.h"

namespace vantage {

/// Of the size and rate asked for, in 1 mm or else in 0.1 mm. Nothing: the sensor has none.
std::optional<openni::VideoMode> FindDepthMode(const openni::SensorInfo& sensor,
                                               const StreamRequest& request);

/// RGB or gray that can be made what was asked for, if possible of the size and rate asked for, or
/// else of one near it. Nothing: the sensor has neither.
std::optional<openni::VideoMode> FindColorMode(const openni::SensorInfo& sensor,
                                               const StreamRequest& request);

bool SameMode(const openni::VideoMode& a, const openni::VideoMode& b);

/// "640x480 at 30 Hz in 1 mm, ..."; "none".
std::string ModeList(const openni::SensorInfo& sensor);

}  // namespace vantage
