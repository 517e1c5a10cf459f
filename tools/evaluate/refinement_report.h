#pragma once

#include <filesystem>
#include <string>

#include "common/result.h"
#include "tools/evaluate/refinement_study.h"

namespace vantage {

/// The summary as lines of text, all sequences first.
std::string RefinementText(const RefinementStudyResults& results);

/// Writes report.html, sequences.csv and figures/errors.svg to a folder that is made if need be,
/// each file whole or not at all. Errors: gnuplot as RunGnuplot, a file can't be written.
Result<void> WriteRefinementReport(const RefinementStudyResults& results,
                                   const std::filesystem::path& folder);

}  // namespace vantage
