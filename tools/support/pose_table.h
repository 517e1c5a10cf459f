#pragma once

#include <string>

#include "tools/support/pose_summary.h"

namespace vantage {

/// Text: a line for each model and estimator, the totals last.
std::string PoseTable(const PoseComparison& comparison);

}  // namespace vantage
