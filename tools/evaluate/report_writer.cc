#include "tools/evaluate/report_writer.h"

#include <string>
#include <utility>
#include <vector>

#include "common/format.h"
#include "tools/evaluate/report_document.h"
#include "tools/evaluate/report_files.h"
#include "tools/evaluate/results_csv.h"
#include "tools/evaluate/results_json.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

Result<void> CheckLength(const std::string& what, size_t length, size_t expected) {
  if (length == expected) return {};
  return Error{ErrorCode::kInvalidArgument,
               Format("%s has %zu entries, expected %zu", what.c_str(), length, expected)};
}

Result<void> CheckRows(const std::string& what,
                       const std::vector<std::vector<double>>& rows,
                       size_t num_rows,
                       size_t length) {
  if (Result<void> checked = CheckLength(what, rows.size(), num_rows); !checked) return checked;
  for (const std::vector<double>& row : rows) {
    if (Result<void> checked = CheckLength("a row of " + what, row.size(), length); !checked) {
      return checked;
    }
  }
  return {};
}

Result<void> CheckObject(const CircleErrors& object, size_t methods) {
  const std::string of = " of " + object.model_id;
  const size_t views = object.detection_deg.size();
  Result<void> checked =
      CheckLength("detection_symmetric_deg" + of, object.detection_symmetric_deg.size(), views);
  if (checked) checked = CheckRows("step_deg" + of, object.step_deg, methods, views);
  if (checked) {
    checked = CheckRows("step_symmetric_deg" + of, object.step_symmetric_deg, methods, views);
  }
  if (checked) {
    checked = CheckRows(
        "particle_runs_deg" + of, object.particle_runs_deg, object.particle_runs_deg.size(), views);
  }
  return checked;
}

}  // namespace

Result<void> CheckShapes(const EvaluationResults& results) {
  const size_t methods = results.methods.size();
  const ClusteringSweep& sweep = results.sweep;
  Result<void> checked = CheckRows(
      "sweep.mean_error_deg", sweep.mean_error_deg, sweep.w_min.size(), sweep.w_max.size());
  if (checked) {
    checked = CheckRows(
        "sweep.wrong_mode_rate", sweep.wrong_mode_rate, sweep.w_min.size(), sweep.w_max.size());
  }
  for (const CircleErrors& object : results.circle) {
    if (checked) checked = CheckObject(object, methods);
  }
  for (const SequenceErrors& object : results.sequences) {
    const size_t count = object.final_deg.empty() ? 0 : object.final_deg.front().size();
    if (checked) {
      checked = CheckRows("final_deg of " + object.model_id, object.final_deg, methods, count);
    }
  }
  if (checked && !results.accuracy.empty()) {
    checked = CheckLength("accuracy", results.accuracy.size(), methods);
  }
  return checked;
}

Result<void> WriteEvaluation(const EvaluationResults& results, const fs::path& folder) {
  if (Result<void> checked = CheckShapes(results); !checked) return checked;
  const Result<ReportFigures> figures = DrawFigures(results);
  if (!figures) return figures.error();
  std::vector<std::pair<std::string, std::string>> files;
  files.emplace_back("grid.csv", GridCsv(results));
  files.emplace_back("sweep.csv", SweepCsv(results));
  files.emplace_back("circle.csv", CircleCsv(results));
  files.emplace_back("sequences.csv", SequencesCsv(results));
  files.emplace_back("accuracy.csv", AccuracyCsv(results));
  files.emplace_back("results.json", ResultsJson(results));
  files.emplace_back("report.html", EvaluationPage(results, *figures));
  return WriteReportFiles(folder, *figures, files);
}

}  // namespace vantage
