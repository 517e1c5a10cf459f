#include "tools/support/pose_table.h"

#include "common/format.h"

namespace vantage {
namespace {

std::string Line(const PoseSummary& summary) {
  std::string line = Format("%-20s %-17s %6zu %9.2f %9.2f %7.1f %7.1f %7.2f %7.2f ",
                            summary.model.c_str(),
                            summary.estimator.c_str(),
                            summary.views,
                            summary.median_ms,
                            summary.p99_ms,
                            summary.within_pct,
                            summary.success_pct,
                            summary.median_deg,
                            summary.median_mm);
  for (const auto& [stage, ms] : summary.stages_ms) line += Format(" %s %.2f", stage.c_str(), ms);
  return line + "\n";
}

}  // namespace

std::string PoseTable(const PoseComparison& comparison) {
  std::string text = Format("%-20s %-17s %6s %9s %9s %7s %7s %7s %7s  %s\n",
                            "model",
                            "estimator",
                            "views",
                            "median ms",
                            "p99 ms",
                            "within%",
                            "succ. %",
                            "deg",
                            "mm",
                            "medians of the stages, ms");
  std::string model;
  for (const PoseSummary& summary : comparison.summaries()) {
    if (!model.empty() && model != summary.model) text += "\n";
    model = summary.model;
    text += Line(summary);
  }
  text +=
      "within: 5 deg and 5 % of the diameter of the truth modulo symmetry; succ.: also those that\n"
      "can't be told from it in that view. deg, mm: medians of those within.\n";
  return text;
}

}  // namespace vantage
