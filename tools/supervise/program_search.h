#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace vantage {

/// The absolute path of a file that may be executed.
std::optional<std::filesystem::path> ExecutableFile(const std::filesystem::path& file);

/// As a shell does: the first of that name in the folders of PATH.
std::optional<std::filesystem::path> FindProgram(const std::string& name);

}  // namespace vantage
