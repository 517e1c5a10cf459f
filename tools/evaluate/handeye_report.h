#pragma once

#include <filesystem>

#include "common/result.h"
#include "tools/evaluate/handeye_results.h"

namespace vantage {

/// Writes report.html, handeye.csv and figures/NAME.svg to a folder that is made if need be, each
/// file whole or not at all, nothing before all is drawn. Errors: gnuplot as RunGnuplot, the folder
/// or a file can't be written.
Result<void> WriteHandEyeReport(const HandEyeResults& results, const std::filesystem::path& folder);

}  // namespace vantage
