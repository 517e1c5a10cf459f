#pragma once

#include <string>
#include <vector>

#include "common/result.h"
#include "tools/support/color.h"
#include "tools/support/run_metrics.h"

namespace vantage {

/// Error by view as SVG: every object's fused estimate as a line, its refined pose as a dashed
/// one, the views' own detections as circles of the same color; degrees, logarithmic; empty when no error is known. Errors as
/// RunGnuplot.
/// @param colors of metrics.objects.
Result<std::string> ErrorFigure(const RunMetrics& metrics, const std::vector<Rgb>& colors);

}  // namespace vantage
