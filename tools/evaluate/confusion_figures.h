#pragma once

#include "common/result.h"
#include "tools/evaluate/confusion_results.h"
#include "tools/evaluate/report_html.h"

namespace vantage {

/// SVG by name: "needed" (mean views by object and strategy), "open" (share of sequences in which
/// the right mode does not hold yet), "calibration", "steps" (Fig. 18). Those without data are not
/// there. Errors as RunGnuplot.
Result<ReportFigures> DrawConfusionFigures(const ConfusionResults& results);

}  // namespace vantage
