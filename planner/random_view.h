#pragma once

#include <cstdint>

#include "planner/view_criterion.h"

namespace vantage {

/// Gain: a number drawn anew after each view, so that every candidate is as likely to be selected:
/// what the paper compares with (7.5). The same for the same seed and number of visited views.
ViewCriterion RandomView(uint64_t seed);

}  // namespace vantage
