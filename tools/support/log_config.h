#pragma once

#include <string>

#include "common/result.h"
#include "nodes/config_reader.h"

namespace vantage {

/// Opens the configuration with which a log is to be read.
/// @param config_file TOML; empty: the text in the log's LOG_HEADER.
/// Errors: the file; the log; no LOG_HEADER with a configuration as its first event.
Result<ConfigReader> OpenConfig(const std::string& config_file, const std::string& log);

}  // namespace vantage
