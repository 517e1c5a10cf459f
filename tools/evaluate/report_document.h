#pragma once

#include <string>

#include "common/result.h"
#include "tools/evaluate/report_html.h"

namespace vantage {

/// Every figure that the results have data for. Errors as RunGnuplot.
Result<ReportFigures> DrawFigures(const EvaluationResults& results);

/// The whole page: summary, the paper's exhibits beside its numbers, sequences, time. It needs no
/// other file.
std::string EvaluationPage(const EvaluationResults& results, const ReportFigures& figures);

}  // namespace vantage
