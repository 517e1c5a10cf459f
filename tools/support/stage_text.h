#pragma once

#include <string>

#include "tools/support/stage_trace.h"

namespace vantage {

/// A line on the image, one for each cluster and each of its models, and one for each detection.
std::string DescribeStages(const StageTrace& trace, const StageImage& image, double min_score);

}  // namespace vantage
