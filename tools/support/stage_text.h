#pragma once

#include <string>

#include "perception/verification/verification.h"
#include "tools/support/stage_trace.h"

namespace vantage {

/// A line on the image, one for each cluster and each of its models, and one for each detection.
std::string DescribeStages(const StageTrace& trace,
                           const StageImage& image,
                           const VerificationParameters& bounds);

}  // namespace vantage
