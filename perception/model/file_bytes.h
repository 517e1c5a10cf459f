#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

#include "common/result.h"

namespace vantage {

/// A whole file. Errors: absent, not a regular file, larger than `largest` bytes, unreadable.
Result<std::string> ReadFileBytes(const std::filesystem::path& file, size_t largest);

/// Errors: the system refuses; what was written of the file is then removed.
Result<void> WriteFileBytes(const std::filesystem::path& file, std::string_view bytes);

}  // namespace vantage
