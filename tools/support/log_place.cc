#include "tools/support/log_place.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "common/format.h"

namespace vantage {
namespace {

// No log is so many seconds long, and none was recorded in the first weeks of 1970.
constexpr double kLeastUtime = 1e12;
constexpr double kLargestUtime = 9e15;  // Which a double still holds to the microsecond.

}  // namespace

Result<int64_t> ParseLogPlace(const std::string& option,
                              const std::string& text,
                              int64_t start_utime) {
  double value = 0.0;
  const char* end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || rest != end || !(value >= 0.0) || value > kLargestUtime) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("%s is '%.40s', expected seconds from the log's start (12.5) or a utime in "
                        "microseconds",
                        option.c_str(),
                        text.c_str())};
  }
  if (value >= kLeastUtime) return static_cast<int64_t>(std::llround(value));
  const double utime = static_cast<double>(start_utime) + 1e6 * value;
  return static_cast<int64_t>(std::llround(std::min(utime, kLargestUtime)));
}

}  // namespace vantage
