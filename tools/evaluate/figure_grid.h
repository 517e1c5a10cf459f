#pragma once

#include <string>
#include <vector>

#include "common/result.h"
#include "tools/evaluate/evaluation_results.h"

namespace vantage {

/// How many of the bins' values are in each bin if angles of rotation are spread evenly over SO(3):
/// in proportion to sin^2(theta / 2) (paper 4.2), integrated over the bin.
std::vector<double> UniformAngleCounts(const BinCounts& bins);

/// Fig. 4: angles of the grid's representatives with UniformAngleCounts, and the distances to their
/// nearest neighbors. SVG, empty without either. Errors as RunGnuplot.
Result<std::string> GridFigure(const EvaluationResults& results);

/// Fig. 8: mean error and wrong-mode rate by w_min and w_max, a frame round the least and a dashed
/// one round the paper's choice. SVG, empty without a sweep. Errors as RunGnuplot.
Result<std::string> SweepFigure(const EvaluationResults& results);

}  // namespace vantage
