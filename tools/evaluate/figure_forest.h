#pragma once

#include <string>

#include "common/result.h"
#include "tools/evaluate/evaluation_results.h"

namespace vantage {

/// Every method's median error and wrong-mode rate with intervals, and their differences to the
/// best variant of ours: filled where the interval excludes 0, hollow where it doesn't. SVG, empty
/// without EvaluationResults::accuracy. Errors as RunGnuplot.
Result<std::string> ForestFigure(const EvaluationResults& results);

/// Median computing time per view of every method, milliseconds, logarithmic. SVG, empty without
/// accuracy. Errors as RunGnuplot.
Result<std::string> TimeFigure(const EvaluationResults& results);

}  // namespace vantage
