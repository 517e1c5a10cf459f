#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

#include "tests/drivers/v4l2_shim/description.h"

namespace vantage::v4l2_shim {

/// What a device remembers for as long as it is plugged in, for all processes: a small text file,
/// which tests may read.
struct DeviceState {
  uint32_t fourcc = 0;
  uint32_t width = 0;   ///< px
  uint32_t height = 0;  ///< px
  Fraction rate;        ///< Hz
  std::map<std::string, int32_t> controls;
};

/// The file's content, what it lacks as it is after plugging in. Formats that the device has no
/// longer are replaced by its first.
DeviceState LoadState(const std::filesystem::path& root, const Device& device);
void SaveState(const std::filesystem::path& root, const Device& device, const DeviceState& state);

/// True where the control follows another one that is automatic.
bool IsInactive(const DeviceState& state, const std::string& control);

}  // namespace vantage::v4l2_shim
