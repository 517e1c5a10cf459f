#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "common/result.h"
#include "vantage/log_header_t.hpp"

namespace vantage {

/// What a recording says of the set-up that it is of.
struct LogSetup {
  std::string config_text;  ///< TOML with absolute paths; empty: unknown
  int64_t seed = 0;         ///< of the estimators
};

/// Of a set-up's file; of an empty name an empty one. Errors: as ConfigReader::Open(), or a seed
/// that is no number.
Result<LogSetup> ReadLogSetup(const std::filesystem::path& config_file);

/// The first event of a log: this program's version and message types, and the set-up.
/// @param utime us since the epoch at which the log starts.
log_header_t MakeLogHeader(const LogSetup& setup, int64_t utime);

}  // namespace vantage
