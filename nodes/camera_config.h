#pragma once

#include <map>
#include <optional>
#include <string>

#include "bus/image_conversion.h"
#include "common/result.h"
#include "drivers/camera/camera.h"
#include "drivers/camera/camera_calibration.h"
#include "nodes/config_reader.h"

namespace vantage {

/// What [camera.<NAME>] says.
struct CameraConfig {
  std::string name;  ///< the <NAME> of the channels
  DeviceSelector device;
  StreamRequest stream;
  double stall_timeout_s = 1.0;  ///< s without a frame
  double rate_hz = 10.0;         ///< published at most; 0: every frame
  DepthCompression compression = DepthCompression::kVdc;
  std::map<std::string, int64_t> controls;  ///< the device's settings by its names, in its units
  std::optional<CameraCalibration> calibration;
};

/// The table [camera.<NAME>] of the process, among those of its driver ("openni2", "v4l2"): of a
/// process "<driver>-<name>" the one whose NAME it is in capitals, of any other the alphabetically
/// first. Other cameras' tables are left alone.
/// Errors: no such table, a NAME that can't be part of a channel's name; a calibration as above or
/// of another size. Errors of single keys wait for ConfigReader::Finish().
Result<CameraConfig> ReadCameraConfig(ConfigReader& config,
                                      const std::string& process_name,
                                      const std::string& driver);

}  // namespace vantage
