#pragma once

#include <string>
#include <vector>

#include "common/result.h"
#include "tools/evaluate/evaluation_results.h"

namespace vantage {

/// The objects of Fig. 10, as places in EvaluationResults::circle: three at most, those with single
/// runs of the particle filter first.
std::vector<size_t> StepObjects(const EvaluationResults& results);

/// Mean over the runs by view, NaN where no run has an estimate.
std::vector<double> MeanOfRuns(const std::vector<std::vector<double>>& runs);
/// Mean of the values up to each, without NaN.
std::vector<double> RunningMean(const std::vector<double>& values);

/// Fig. 10: errors view by view of StepObjects(): detections, their mean so far, and the compared
/// methods that the paper has. Modulo symmetry, logarithmic. SVG, empty without a circle. Errors as
/// RunGnuplot.
Result<std::string> StepFigure(const EvaluationResults& results);

/// Fig. 15: detections and the best of ours view by view, for all objects. SVG, empty without a
/// circle. Errors as RunGnuplot.
Result<std::string> ObjectsFigure(const EvaluationResults& results);

}  // namespace vantage
