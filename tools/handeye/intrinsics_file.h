#pragma once

#include <filesystem>
#include <string>

#include "common/camera_intrinsics.h"
#include "common/result.h"

namespace vantage {

/// Reads a calibration file of the camera driver (TOML, docs/drivers.md) or ViSP's XML of a
/// camera, whose kud becomes k1. Errors: absent, another format, keys that are missing, unknown or
/// out of range.
Result<CameraIntrinsics> ReadIntrinsics(const std::filesystem::path& file);

/// As a calibration file of the camera driver.
std::string IntrinsicsToml(const CameraIntrinsics& intrinsics);

}  // namespace vantage
