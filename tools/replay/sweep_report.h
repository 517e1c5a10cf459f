#pragma once

#include <string>
#include <vector>

#include "common/result.h"
#include "tools/replay/sweep_run.h"

namespace vantage {

/// One line a cell, for people.
std::string SweepTable(const SweepGrid& grid, const std::vector<SweepCell>& cells);

/// One line for each object of each log and cell: errors in deg and mm, empty where there is none.
std::string SweepCsv(const SweepGrid& grid,
                     const std::vector<std::string>& logs,
                     const std::vector<SweepCell>& cells);

std::string SweepJson(const SweepGrid& grid,
                      const std::vector<std::string>& logs,
                      const std::vector<SweepCell>& cells);

/// Median errors by the first parameter, a line for each combination of the others, with intervals
/// where there are several logs. SVG. Errors as RunGnuplot.
Result<std::string> SweepFigure(const SweepGrid& grid, const std::vector<SweepCell>& cells);

}  // namespace vantage
