#pragma once

#include <filesystem>
#include <string>

#include "common/result.h"
#include "nodes/camera_config.h"
#include "nodes/config_reader.h"

namespace vantage {

/// What [camera.<NAME>] says with driver = "openni2".
struct Openni2Config {
  CameraConfig camera;
  std::filesystem::path record_file;  ///< into which the camera is recorded; empty: it is not
};

/// The table of the process, as of ReadCameraConfig(), with the keys that only OpenNI2 has.
/// Errors: as there; a layout of color that OpenNI2 does not give; a recording of a recording.
Result<Openni2Config> ReadOpenni2Config(ConfigReader& config, const std::string& process_name);

}  // namespace vantage
