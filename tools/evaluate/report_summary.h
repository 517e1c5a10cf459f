#pragma once

#include <string>

#include "tools/evaluate/report_html.h"

namespace vantage {

/// What was run: command, version, seed, counts, metric.
std::string RunSection(const EvaluationResults& results);

/// Which variant of ours is best and how it stands to every other method: sentences, table, forest
/// plot.
std::string SummarySection(const EvaluationResults& results, const ReportFigures& figures);

/// Median error of every method on every object's sequences.
std::string SequencesSection(const EvaluationResults& results);

/// Computing time per view.
std::string TimeSection(const EvaluationResults& results, const ReportFigures& figures);

}  // namespace vantage
