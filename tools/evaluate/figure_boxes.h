#pragma once

#include <string>

#include "common/result.h"
#include "tools/evaluate/evaluation_results.h"

namespace vantage {

/// Fig. 14: box plots of every method's final errors over the objects on the circle, all of them on
/// a logarithmic axis and the smaller ones on a linear axis; the paper's medians (7.3.2) as
/// diamonds. An orientation that is not there counts as kMissingErrorDeg. SVG, empty without a
/// circle. Errors as RunGnuplot.
/// @param symmetric modulo symmetry.
Result<std::string> BoxFigure(const EvaluationResults& results, bool symmetric);

}  // namespace vantage
