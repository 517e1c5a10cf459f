#pragma once

#include <filesystem>

#include "common/gray_image.h"
#include "common/result.h"

namespace vantage {

/// Reads a PNG or JPEG image as brightness. Errors: absent, larger than 256 MiB, neither of both,
/// sides outside of 1..16384 px or more pixels than its bytes can hold, damaged.
Result<GrayImage> ReadGrayImage(const std::filesystem::path& file);

}  // namespace vantage
