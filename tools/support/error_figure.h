#pragma once

#include <string>

#include "common/result.h"
#include "tools/support/run_metrics.h"

namespace vantage {

/// Error by view as SVG: every object's fused estimate as a line, the views' own detections as dots
/// of the same color; degrees, logarithmic. Errors as RunGnuplot; no errors to draw.
Result<std::string> ErrorFigure(const RunMetrics& metrics);

}  // namespace vantage
