#pragma once

#include <string>

#include "tools/support/recorded_run.h"
#include "tools/support/report_setup.h"
#include "tools/support/run_metrics.h"

namespace vantage {

/// The bars that a run is held against.
struct ReportLimits {
  double rotation_deg = 2.0;
  double position_mm = 3.0;
};

/// A page of its own (pictures inside): summary, scene, errors by view, every view with its depth
/// and estimates, orientation histograms. Errors: gnuplot is missing, a picture can't be encoded.
Result<std::string> ReportPage(const std::string& title,
                               const RecordedRun& run,
                               const ReportSetup& setup,
                               const RunMetrics& metrics,
                               const ReportLimits& limits);

/// The summary as a table for a terminal.
std::string SummaryTable(const RunMetrics& metrics, const ReportLimits& limits);
/// Each view's own error and the fused one, for a terminal.
std::string ViewTable(const RunMetrics& metrics);
/// object,instance,view,detected_deg,detected_mm,fused_deg,fused_mm,refined_deg,refined_mm
std::string ErrorsCsv(const RunMetrics& metrics);
/// The same with the summary, as JSON.
std::string ReportJson(const RunMetrics& metrics, const ReportLimits& limits);

}  // namespace vantage
