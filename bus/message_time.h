#pragma once

#include <cstdint>

#include "common/format.h"
#include "common/result.h"
#include "common/time_range.h"

namespace vantage {

/// Errors: a time that is not in the range of IsPlausibleUtime().
/// @param field for the sentence, e.g. "images_t.utime".
inline Result<void> CheckUtime(const char* field, int64_t utime) {
  if (IsPlausibleUtime(utime)) return {};
  return Error{ErrorCode::kInvalidArgument,
               Format("%s is %jd us since the epoch, expected 0 to %jd (the year 2200)",
                      field,
                      intmax_t{utime},
                      intmax_t{kLatestUtime})};
}

}  // namespace vantage
