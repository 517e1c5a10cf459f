#pragma once

#include <filesystem>
#include <string>

#include "common/result.h"
#include "tools/evaluate/confusion_results.h"
#include "tools/evaluate/report_html.h"

namespace vantage {

/// The whole page; it needs no other file. Error: a picture that is no picture.
Result<std::string> ConfusionPage(const ConfusionResults& results, const ReportFigures& figures);

/// Writes report.html, results.json, reweighting.csv, views_needed.csv, steps.csv, figures/NAME.svg
/// and figures/NAME.png to a folder that is made if need be, each file whole or not at all, nothing
/// before all is drawn. Errors: gnuplot as RunGnuplot, the folder or a file can't be written.
Result<void> WriteConfusionReport(const ConfusionResults& results,
                                  const std::filesystem::path& folder);

}  // namespace vantage
