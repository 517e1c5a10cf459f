#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace vantage {

/// "2026-11-22 20:52:35.578696 UTC"; a number of microseconds where that is no time of 1970 to
/// 2200.
std::string UtcText(int64_t utime);
/// The same in the zone of this machine, with its name.
std::string LocalTimeText(int64_t utime);
/// "8.3 kB", "7.0 MB", "10.0 GB".
std::string BytesText(int64_t bytes);

/// What a file says, fit for a terminal: other bytes than printable ASCII become \xNN.
std::string Printable(std::string_view text);

}  // namespace vantage
