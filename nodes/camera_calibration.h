#pragma once

#include <filesystem>

#include "common/result.h"
#include "drivers/camera/camera_calibration.h"

namespace vantage {

/// Reads a calibration file (TOML, docs/config.md). Its id is the file's name and the hash of its
/// content. Errors: absent, no TOML, keys that are missing, unknown or out of range.
Result<CameraCalibration> LoadCameraCalibration(const std::filesystem::path& file);

}  // namespace vantage
