#include "tools/evaluate/refinement_report.h"

#include <algorithm>
#include <vector>

#include "common/format.h"
#include "tools/evaluate/figure_style.h"
#include "tools/evaluate/report_files.h"
#include "tools/evaluate/report_html.h"
#include "tools/support/csv_field.h"
#include "tools/support/gnuplot.h"
#include "tools/support/html.h"

namespace vantage {
namespace {

// The share of sequences below an error, fused and refined.
std::string FigureScript(const RefinementStudyResults& results) {
  std::string script = FigureHead(760, 420);
  std::vector<double> fused;
  std::vector<double> refined;
  for (const RefinedSequence& sequence : results.sequences) {
    fused.push_back(DrawnError(sequence.fused_deg));
    refined.push_back(DrawnError(sequence.refined_deg));
  }
  const auto data = [&](const char* name, std::vector<double> values) {
    std::sort(values.begin(), values.end());
    script += Format("$%s << EOD\n", name);
    for (size_t i = 0; i < values.size(); ++i) {
      script += Format("%g %g\n",
                       values[i],
                       100.0 * static_cast<double>(i + 1) / static_cast<double>(values.size()));
    }
    script += "EOD\n";
  };
  data("fused", fused);
  data("refined", refined);
  script +=
      "set logscale x\nset xlabel 'rotation error modulo symmetry (deg)'\n"
      "set ylabel 'sequences below (%)'\nset yrange [0:100]\nset key bottom right\nset grid\n";
  script += Format(
      "plot $fused using 1:2 with steps lw 2 lc rgb '%s' title 'fused, density mode', "
      "$refined using 1:2 with steps lw 3 lc rgb '%s' title 'refined on all views'\n",
      kOtherColor,
      kOursColor);
  return script;
}

std::string Csv(const RefinementStudyResults& results) {
  std::string csv =
      "model,index,views,fused_deg,refined_deg,fused_mm,refined_mm,is_refined,squared_deviation,"
      "freedom,seconds,note\n";
  for (const RefinedSequence& s : results.sequences) {
    csv += CsvField(s.model_id) + Format(",%d,%d,", s.index, s.views);
    for (const double value : {s.fused_deg, s.refined_deg, s.fused_mm, s.refined_mm}) {
      csv += CsvField(value) + ",";
    }
    csv += Format("%d,", s.is_refined ? 1 : 0) + CsvField(s.squared_deviation);
    csv += Format(",%d,", s.freedom) + CsvField(s.seconds) + "," + CsvField(s.note) + "\n";
  }
  return csv;
}

std::string SummaryTable(const RefinementStudyResults& results) {
  std::string rows = "<tr>";
  for (const char* head : {"model",
                           "sequences",
                           "refused",
                           "fused, deg",
                           "refined, deg",
                           "ratio",
                           "90 % below: fused",
                           "refined",
                           "fused, mm",
                           "refined, mm",
                           "worse by 10 %",
                           "largest ratio",
                           "coverage, %",
                           "10 views, ms"}) {
    rows += HeadCell(head);
  }
  rows += "</tr>";
  for (const RefinementSummary& s : Summarize(results)) {
    rows += "<tr>" + HtmlCell(s.name) + HtmlCell(std::to_string(s.count)) +
            HtmlCell(std::to_string(s.refused)) + IntervalCell(s.fused_deg, 1.0, 4) +
            IntervalCell(s.refined_deg, 1.0, 4) +
            HtmlCell(Format("%.2f", s.refined_deg.value / s.fused_deg.value)) +
            HtmlCell(Format("%.4f", s.fused_90_deg)) + HtmlCell(Format("%.4f", s.refined_90_deg)) +
            HtmlCell(Format("%.3f", s.fused_mm)) + HtmlCell(Format("%.3f", s.refined_mm)) +
            HtmlCell(std::to_string(s.worse)) + HtmlCell(Format("%.2f", s.largest_ratio)) +
            HtmlCell(Format("%.1f", 100.0 * s.coverage)) +
            HtmlCell(Format("%.1f", 1e3 * s.seconds_of_10)) + "</tr>";
  }
  return TableCard(rows,
                   "Medians with 95 % bootstrap intervals drawn within each model. Coverage is of "
                   "the covariance's 95 % ellipsoid in rotation and translation.");
}

std::string TurntableText(const TurntableRefinement& t) {
  return Format(
      "turntable, %d views: %.3f deg and %.2f mm from the consensus of the views' own ICPs (the "
      "nearest view %.3f deg, %.2f mm; fused %.3f deg), %.3f deg and %.2f mm from the markers' "
      "truth (fused %.3f deg)%s%s",
      t.views,
      t.consensus_deg,
      t.consensus_mm,
      t.nearest_view_deg,
      t.nearest_view_mm,
      t.fused_consensus_deg,
      t.truth_deg,
      t.truth_mm,
      t.fused_truth_deg,
      t.is_refined ? "" : "; refused: ",
      t.note.c_str());
}

std::string Page(const RefinementStudyResults& results, const ReportFigures& figures) {
  std::string page =
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
      "content=\"width=device-width,initial-scale=1\"><title>Refinement over several views</title>"
      "<style>";
  page += ReportStyle();
  page += "</style></head><body><main><h1>Refinement over several views</h1>";
  page += "<p><code>" + EscapeHtml(results.command) + "</code></p>";
  page += Section("errors",
                  "Before and after",
                  "The same depth and detections; refined from the fused pose.",
                  FigureCard(figures,
                             "errors",
                             "Share of sequences below an error, fused and refined",
                             "Left is better.") +
                      SummaryTable(results));
  if (results.turntable) {
    page += Section("turntable",
                    "Real views",
                    "A printed bunny on a turntable, camera poses by markers.",
                    "<p>" + EscapeHtml(TurntableText(*results.turntable)) + "</p>");
  }
  std::string list;
  for (const std::string& bar : MissedBars(results)) list += "<li>" + EscapeHtml(bar) + "</li>";
  page += Section("missed",
                  "Bars that are missed",
                  list.empty() ? "None." : "What is asked for and not reached.",
                  list.empty() ? "" : "<ul>" + list + "</ul>");
  return page + "</main></body></html>\n";
}

}  // namespace

std::string RefinementText(const RefinementStudyResults& results) {
  std::string text;
  for (const RefinementSummary& s : Summarize(results)) {
    text += Format(
        "%-14s %4d sequences, %d refused: fused %.4f, refined %.4f (%.4f..%.4f) deg, ratio %.2f; "
        "90 %% below %.4f, %.4f; %.3f, %.3f mm; %d worse by 10 %%, at most %.2f; coverage %.1f %%; "
        "%.1f ms\n",
        s.name.c_str(),
        s.count,
        s.refused,
        s.fused_deg.value,
        s.refined_deg.value,
        s.refined_deg.low,
        s.refined_deg.high,
        s.refined_deg.value / s.fused_deg.value,
        s.fused_90_deg,
        s.refined_90_deg,
        s.fused_mm,
        s.refined_mm,
        s.worse,
        s.largest_ratio,
        100.0 * s.coverage,
        1e3 * s.seconds_of_10);
  }
  if (results.turntable) text += TurntableText(*results.turntable) + "\n";
  return text;
}

Result<void> WriteRefinementReport(const RefinementStudyResults& results,
                                   const std::filesystem::path& folder) {
  ReportFigures figures;
  if (!results.sequences.empty()) {
    Result<std::string> figure = RunGnuplot(FigureScript(results));
    if (!figure) return figure.error();
    figures["errors"] = std::move(figure).value();
  }
  return WriteReportFiles(
      folder, figures, {{"sequences.csv", Csv(results)}, {"report.html", Page(results, figures)}});
}

}  // namespace vantage
