#pragma once

#include <filesystem>
#include <string>

#include "common/result.h"

namespace vantage {

/// Writes a file whole or not at all: beside it first, then renamed. Errors: the system refuses.
Result<void> WriteWholeFile(const std::filesystem::path& file, const std::string& text);

}  // namespace vantage
