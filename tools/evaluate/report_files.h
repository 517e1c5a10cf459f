#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "common/result.h"
#include "tools/evaluate/report_html.h"

namespace vantage {

/// Makes the folder where it is not there, writes figures to figures/NAME.svg, then the texts, each
/// by its file's name. Errors: the system refuses; what was written before stays.
Result<void> WriteReportFiles(const std::filesystem::path& folder,
                              const ReportFigures& figures,
                              const std::vector<std::pair<std::string, std::string>>& texts);

}  // namespace vantage
