#pragma once

#include <filesystem>
#include <string>

#include "common/result.h"
#include "tools/evaluate/dataset_results.h"

namespace vantage {

/// The whole page, which needs no other file: summary, bounds, and of each dataset every outcome
/// with a picture of the depth and the model's outline in the estimated pose (in the true one where
/// nothing was found). Errors: a picture can't be encoded.
Result<std::string> DatasetPage(const DatasetResults& results);

/// Writes report.html, views.csv and results.json to a folder that is made if need be, each whole
/// or not at all. Errors: as DatasetPage(), the folder or a file (named) can't be written.
Result<void> WriteDatasetReport(const DatasetResults& results, const std::filesystem::path& folder);

}  // namespace vantage
