#include "tools/evaluate/handeye_report.h"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "common/format.h"
#include "tools/evaluate/handeye_figures.h"
#include "tools/evaluate/handeye_text.h"
#include "tools/evaluate/report_files.h"
#include "tools/evaluate/report_html.h"
#include "tools/support/html.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

constexpr const char* kBarStyle = "td.met { color:var(--good); } td.missed { color:var(--bad); }";

std::string HeadRow(const std::vector<std::string>& heads) {
  std::string row = "<tr>";
  for (const std::string& head : heads) row += HeadCell(head);
  return row + "</tr>";
}

std::string Expected(const HandEyeBar& bar) {
  if (std::isfinite(bar.low) && std::isfinite(bar.high)) {
    return Format("%g to %g %s", bar.low, bar.high, bar.unit.c_str());
  }
  return std::isfinite(bar.low) ? Format("at least %g %s", bar.low, bar.unit.c_str())
                                : Format("at most %g %s", bar.high, bar.unit.c_str());
}

std::string BarsTable(const HandEyeResults& results) {
  std::string rows = HeadRow({"bar", "expected", "reached", ""});
  for (const HandEyeBar& bar : results.bars) {
    rows += "<tr>" + HtmlCell(bar.name) + HtmlCell(Expected(bar)) +
            HtmlCell(Format("%.3f %s", bar.value, bar.unit.c_str())) +
            HtmlCell(bar.met ? "● met" : "○ missed", bar.met ? "met" : "missed") + "</tr>";
  }
  return TableCard(
      rows, "30 views unless said otherwise; the time is the median of all trials on one core.");
}

/// The methods of one cell, best in bold.
std::string CellTables(const HandEyeResults& results) {
  std::string html;
  std::string group;
  std::string rows;
  const auto finish = [&] {
    if (rows.empty()) return;
    html += "<h3>" + EscapeHtml(group) + "</h3>" + TableCard(rows, "", "dense");
    rows.clear();
  };
  for (const HandEyeCell& cell : results.cells) {
    const std::string of = Format("%s, %d views, %.0f %% outliers",
                                  cell.setup.c_str(),
                                  cell.views,
                                  100.0 * cell.outlier_share);
    if (of != group) {
      finish();
      group = of;
      rows = HeadRow({"method",
                      "median (mm)",
                      "median (°)",
                      "RMSE (mm)",
                      "RMSE (°)",
                      "by the bound, mm",
                      "by the bound, °",
                      "ms",
                      "failed"});
    }
    const bool is_ours = cell.method == results.methods.front();
    rows += std::string(is_ours ? "<tr class=\"best\">" : "<tr>") +
            HtmlCell(cell.method, is_ours ? "ours" : "") + IntervalCell(cell.median_mm, 1, 3) +
            IntervalCell(cell.median_deg, 1, 4) + IntervalCell(cell.rmse_mm, 1, 3) +
            IntervalCell(cell.rmse_deg, 1, 4) + IntervalCell(cell.ratio_translation, 1, 3) +
            IntervalCell(cell.ratio_rotation, 1, 3) + HtmlCell(Format("%.2f", cell.median_ms)) +
            HtmlCell(Format("%d of %d", cell.failed, cell.trials)) + "</tr>";
  }
  finish();
  return html;
}

std::string SelfTable(const HandEyeResults& results) {
  std::string rows = HeadRow({"setup",
                              "views",
                              "outliers (%)",
                              "trials",
                              "coverage (%)",
                              "false alarms (%)",
                              "wrong views (%)"});
  for (const HandEyeSelfTest& test : results.self_tests) {
    rows += "<tr>" + HtmlCell(test.setup) + HtmlCell(std::to_string(test.views)) +
            HtmlCell(Format("%.0f", 100.0 * test.outlier_share)) +
            HtmlCell(std::to_string(test.trials)) + IntervalCell(test.coverage, 100.0, 1) +
            IntervalCell(test.false_alarms, 100.0, 2) +
            HtmlCell(Format("%.3f", 100.0 * test.wrong_views)) + "</tr>";
  }
  return TableCard(
      rows,
      "Coverage: share of trials whose 95 % ellipsoid of X, six-dimensional, holds the "
      "truth. False alarms: sets held insufficient. Wrong views: outliers taken or "
      "good views left out. Intervals by Wilson.",
      "dense");
}

std::string DegenerateTable(const HandEyeResults& results) {
  std::string rows = HeadRow({"motion", "setup", "outliers (%)", "flagged", "what it says"});
  for (const HandEyeDegenerate& counted : results.degenerate) {
    rows += "<tr>" + HtmlCell(counted.motion) + HtmlCell(counted.setup) +
            HtmlCell(Format("%.0f", 100.0 * counted.outlier_share)) +
            HtmlCell(Format("%d of %d", counted.flagged, counted.trials)) +
            "<td style=\"text-align:left;white-space:normal\">" + EscapeHtml(counted.reason) +
            "</td></tr>";
  }
  return TableCard(rows, "30 views each; what it says in the first trial.", "dense");
}

std::string Page(const HandEyeResults& results, const ReportFigures& figures) {
  std::string page =
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
      "content=\"width=device-width,initial-scale=1\"><title>Hand-eye calibration, "
      "evaluated</title><style>";
  page += ReportStyle();
  page += kBarStyle;
  page +=
      "</style></head><body><main><h1>Hand-eye calibration, evaluated</h1><p class=\"soft\">"
      "Simulated calibrations from poses of a target: robot noise 0.1 mm and 0.02°, camera noise "
      "0.5 mm and 0.1°, outliers 30 mm and 10°, each about every axis. The hand tilts by up to 40° "
      "about two axes, rolls by up to 90° and moves in a box of 0.4 m; the camera is 0.1 m from "
      "the hand and 0.5 m from the target, or 0.8 m from the workspace.</p>";
  page +=
      Section("bars",
              "What has to be reached",
              "",
              BarsTable(results) + "<dl><dt>made by</dt><dd><code>" + EscapeHtml(results.command) +
                  "</code></dd><dt>version</dt><dd>" + EscapeHtml(results.version) +
                  Format("</dd><dt>trials</dt><dd>%d of ours in each cell, the first %d of "
                         "them of the others</dd><dt>seed</dt><dd>%llu</dd></dl>",
                         results.trials,
                         results.peer_trials,
                         static_cast<unsigned long long>(results.seed)));
  page += Section("errors",
                  "Against the others",
                  "",
                  FigureCard(figures,
                             "errors",
                             "median translation error by method",
                             "30 views, 95 % bootstrap intervals; errors beyond 3 m are drawn "
                             "there."));
  page += Section("bound",
                  "Against the bound",
                  "",
                  FigureCard(figures,
                             "bound",
                             "RMSE by the Cramer-Rao bound",
                             "The bound knows which views are outliers. Dashed: 1.05."));
  page += Section(
      "itself",
      "What it says of itself",
      "",
      FigureCard(figures, "coverage", "coverage of the 95 % ellipsoid", "Gray: 93 to 97 %.") +
          SelfTable(results) + DegenerateTable(results));
  page += Section("cells", "All cells", "", CellTables(results));
  return page + "</main></body></html>\n";
}

}  // namespace

Result<void> WriteHandEyeReport(const HandEyeResults& results, const fs::path& folder) {
  const Result<ReportFigures> figures = DrawHandEyeFigures(results);
  if (!figures) return figures.error();
  std::vector<std::pair<std::string, std::string>> files;
  files.emplace_back("handeye.csv", HandEyeCsv(results));
  files.emplace_back("report.html", Page(results, *figures));
  return WriteReportFiles(folder, *figures, files);
}

}  // namespace vantage
