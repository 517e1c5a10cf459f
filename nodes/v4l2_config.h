#pragma once

#include <string>

#include "common/result.h"
#include "drivers/v4l2/v4l2_options.h"
#include "nodes/camera_config.h"
#include "nodes/config_reader.h"

namespace vantage {

/// What [camera.<NAME>] says with driver = "v4l2".
struct V4l2Config {
  CameraConfig camera;
  V4l2Options v4l2;
};

/// The table of the process, as of ReadCameraConfig(), with the keys that only V4L2 has.
/// Errors: as there; a device = "oni:..."; a pixel format that is not read.
Result<V4l2Config> ReadV4l2Config(ConfigReader& config, const std::string& process_name);

}  // namespace vantage
