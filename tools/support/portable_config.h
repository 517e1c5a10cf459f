#pragma once

#include <filesystem>
#include <string>

#include "common/result.h"

namespace vantage {

/// The text of a set-up's TOML file as it goes into a log's header: with every path in it absolute,
/// so that it means the same wherever the log is read. Comments and order stay.
/// @param text the file's text. @param folder where relative paths in it start.
/// Errors: it is no TOML.
Result<std::string> PortableConfigText(const std::string& text,
                                       const std::filesystem::path& folder);

}  // namespace vantage
