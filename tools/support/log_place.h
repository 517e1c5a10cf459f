#pragma once

#include <cstdint>
#include <string>

#include "common/result.h"

namespace vantage {

/// The utime (us since the epoch) of a place in a log as people give it: seconds from the log's
/// start ("12.5"), or a utime.
/// @param option for the sentence: "--from". @param start_utime of the log, us.
/// Errors: no number, or negative.
Result<int64_t> ParseLogPlace(const std::string& option,
                              const std::string& text,
                              int64_t start_utime);

}  // namespace vantage
