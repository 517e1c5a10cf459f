#pragma once

#include "common/result.h"
#include "tools/evaluate/handeye_results.h"
#include "tools/evaluate/report_html.h"

namespace vantage {

/// SVG by name: "errors" (median error by method and share of outliers, 30 views), "bound" (our
/// RMSE by the Cramer-Rao bound), "coverage" (of the 95 % ellipsoid). Errors as RunGnuplot.
Result<ReportFigures> DrawHandEyeFigures(const HandEyeResults& results);

}  // namespace vantage
