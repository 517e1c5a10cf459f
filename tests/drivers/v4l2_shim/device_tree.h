#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tests/drivers/v4l2_shim/description.h"

namespace vantage::v4l2_shim {

/// Makes the folders dev and sys below `root` what they are with these devices plugged in, and
/// forgets the state of those that are gone. What is as it should be is not touched.
void UpdateTree(const std::filesystem::path& root, const std::vector<Device>& devices);

/// True for names that the tree has in place of the system's.
bool IsEmulatedPath(const std::string& path);

/// N of "/dev/videoN"; nothing for any other path.
std::optional<int> NodeNumber(const std::string& path);

}  // namespace vantage::v4l2_shim
