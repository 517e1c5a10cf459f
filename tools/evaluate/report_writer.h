#pragma once

#include <filesystem>

#include "common/result.h"
#include "tools/evaluate/evaluation_results.h"

namespace vantage {

/// Whether the lists have one entry a method, view, bin where they should, so that a report can be
/// made of them. Errors name the list and both lengths.
Result<void> CheckShapes(const EvaluationResults& results);

/// Writes report.html (which needs no other file), results.json, grid.csv, sweep.csv, circle.csv,
/// sequences.csv, accuracy.csv and figures/NAME.svg to a folder that is made if need be. Each
/// file is written whole or not at all; nothing is written before all figures are drawn. Errors:
/// CheckShapes(), gnuplot as RunGnuplot, the folder or a file (named) can't be written.
Result<void> WriteEvaluation(const EvaluationResults& results, const std::filesystem::path& folder);

}  // namespace vantage
