#pragma once

#include <filesystem>
#include <string>

#include "common/result.h"

namespace vantage {

/// Reads a configuration as one of our processes does when it starts, short of its models, devices
/// and the bus.
/// @param program "vantage-ppf", ...; the recorder and others read nothing
/// @param name of the process, by which a driver finds its camera
/// Errors: what the process would say.
Result<void> CheckConfigFor(const std::string& program,
                            const std::string& name,
                            const std::filesystem::path& file);

}  // namespace vantage
