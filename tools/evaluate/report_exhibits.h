#pragma once

#include <string>

#include "tools/evaluate/report_html.h"

namespace vantage {

// The paper's exhibits, ours beside its numbers.

/// Table 1 and Fig. 4: the grid of orientations.
std::string GridSection(const EvaluationResults& results, const ReportFigures& figures);
/// Fig. 8: the parameters of clustering.
std::string SweepSection(const EvaluationResults& results, const ReportFigures& figures);
/// Fig. 10: three objects step by step.
std::string StepsSection(const EvaluationResults& results, const ReportFigures& figures);
/// Table 2: all objects and methods, plain and modulo symmetry.
std::string ObjectsSection(const EvaluationResults& results);
/// Fig. 14: box plots.
std::string BoxesSection(const EvaluationResults& results, const ReportFigures& figures);
/// Fig. 15: all objects step by step.
std::string ViewsSection(const EvaluationResults& results, const ReportFigures& figures);

}  // namespace vantage
