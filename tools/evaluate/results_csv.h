#pragma once

#include <string>

#include "tools/evaluate/evaluation_results.h"

namespace vantage {

// Results as CSV (RFC 4180, first line names the columns): '\n' ends a line, numbers are the
// shortest that read back as the same double, NaN is an empty field. Views and sequences count
// from 1. Angles in degrees.

/// k,num_cells,mean_deg,deviation_deg,megabytes,build_seconds
std::string GridCsv(const EvaluationResults& results);
/// w_min,w_max,mean_error_deg,wrong_mode_rate; only where w_min <= w_max.
std::string SweepCsv(const EvaluationResults& results);
/// model,method,view,error_deg,error_symmetric_deg; the method "detection" is the view's own.
std::string CircleCsv(const EvaluationResults& results);
/// model,sequence,method,error_deg
std::string SequencesCsv(const EvaluationResults& results);
/// A line a method; intervals as X,X_low,X_high.
std::string AccuracyCsv(const EvaluationResults& results);

}  // namespace vantage
