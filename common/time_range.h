#pragma once

#include <cstdint>

namespace vantage {

/// us since the epoch at the start of the year 2200.
inline constexpr int64_t kLatestUtime = 7'258'118'400'000'000;

/// True for 0 to kLatestUtime. Every utime from outside passes this first, so that sums and
/// differences of times can't overflow.
constexpr bool IsPlausibleUtime(int64_t utime) { return utime >= 0 && utime <= kLatestUtime; }

}  // namespace vantage
