#include "tools/evaluate/confusion_report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "common/format.h"
#include "tools/evaluate/confusion_figures.h"
#include "tools/evaluate/confusion_text.h"
#include "tools/evaluate/report_files.h"
#include "tools/evaluate/report_numbers.h"
#include "tools/support/html.h"
#include "tools/support/png_image.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

// Beside the style of all reports.
constexpr const char* kPictureStyle =
    ".pictures { display:grid; grid-template-columns:repeat(auto-fit,minmax(260px,1fr)); "
    "gap:14px; } .pictures figure { margin:0; } .pictures img { width:100%; display:block; "
    "border-radius:6px; background:#fff; } .pictures figcaption { font-size:.82rem; } "
    "td.met { color:var(--good); } td.missed { color:var(--bad); }";

constexpr const char* kNavigation =
    "<nav><a href=\"#summary\">Views needed</a><a href=\"#strategies\">By object</a>"
    "<a href=\"#calibration\">Calibration</a><a href=\"#tables\">Tables</a>"
    "<a href=\"#fig5\">Fig. 5</a><a href=\"#fig6\">Fig. 6</a><a href=\"#table3\">Table 3</a>"
    "<a href=\"#fig16\">Fig. 16, 17</a><a href=\"#fig18\">Fig. 18</a></nav>";

std::string Row(const std::vector<std::string>& cells, const char* css_class = "") {
  std::string row = css_class[0] == '\0' ? "<tr>" : Format("<tr class=\"%s\">", css_class);
  for (const std::string& cell : cells) row += cell;
  return row + "</tr>";
}

std::string HeadRow(const std::vector<std::string>& heads) {
  std::string row = "<tr>";
  for (const std::string& head : heads) row += HeadCell(head);
  return row + "</tr>";
}

std::string Percent(double share, int decimals = 1) {
  return Format("%.*f", decimals, 100.0 * share);
}

std::string BarsTable(const ConfusionResults& results) {
  std::string rows = HeadRow({"bar", "at least", "reached", ""});
  for (const ConfusionBar& bar : results.bars) {
    const bool is_share = bar.unit == "share";
    const auto text = [&](double value) {
      return is_share ? Percent(value) + " %" : Format("%g", value);
    };
    std::string reached = text(bar.value);
    if (is_share) reached += " [" + Percent(bar.low) + ", " + Percent(bar.high) + "]";
    rows += Row({HtmlCell(bar.name),
                 HtmlCell(text(bar.bar)),
                 HtmlCell(reached),
                 HtmlCell(bar.met ? "● met" : "○ missed", bar.met ? "met" : "missed")});
  }
  return TableCard(rows,
                   "Shares are one less the ratio of the mean numbers of views over all sequences "
                   "of all objects, with 95 % bootstrap intervals drawn within each object.");
}

std::string NeededTable(const ConfusionResults& results) {
  std::string rows = HeadRow({"next view by",
                              "mean views",
                              "median",
                              "mean, first reached",
                              "never held (%)",
                              "right at the end (%)",
                              "fewer than random",
                              "fewer than the heuristic",
                              "believed right (%)"});
  for (size_t s = 0; s < results.strategies.size(); ++s) {
    const ViewsNeeded& needed = results.all_objects[s];
    rows +=
        Row({HtmlCell(results.strategies[s], s == 0 ? "ours" : ""),
             IntervalCell(needed.mean, 1, 2),
             HtmlCell(Format("%g", needed.median)),
             HtmlCell(NumberText(needed.reached_mean, 2)),
             HtmlCell(Percent(needed.never_share)),
             HtmlCell(Percent(needed.final_right)),
             IntervalCell(needed.less_random, -1, 2),
             IntervalCell(needed.less_heuristic, -1, 2),
             HtmlCell(needed.claims > 0.0 ? Percent(needed.claims_right / needed.claims) : "–")},
            s == 0 ? "best" : "");
  }
  return TableCard(rows,
                   Format("Views until the belief has %.0f %% of its mass within %g degrees of the "
                          "truth, modulo symmetry, and keeps it to the end; sequences where it "
                          "never does count as %d. Differences are paired by sequence. Believed "
                          "right: how often the best hypothesis is right when it has %.0f %%.",
                          100.0 * results.enough,
                          results.right_angle_deg,
                          results.views + 1,
                          100.0 * results.enough),
                   "dense");
}

std::string ObjectsTable(const ConfusionResults& results) {
  std::vector<std::string> heads = {"object", "symmetry"};
  for (const std::string& label : results.strategies) heads.push_back(label);
  for (const char* head : {"never held (%), ours", "right at the end (%), ours"}) {
    heads.emplace_back(head);
  }
  std::string rows = HeadRow(heads);
  for (const ObjectViewsNeeded& object : results.objects) {
    double least = object.strategies.front().mean.value;
    for (const ViewsNeeded& needed : object.strategies) least = std::min(least, needed.mean.value);
    std::string row = "<tr>" + HtmlCell(object.model_id) + HtmlCell(object.symmetry);
    for (const ViewsNeeded& needed : object.strategies) {
      row += HtmlCell(
          Format("%.2f [%.2f, %.2f]", needed.mean.value, needed.mean.low, needed.mean.high),
          needed.mean.value == least ? "first" : "");
    }
    row += HtmlCell(Percent(object.strategies.front().never_share)) +
           HtmlCell(Percent(object.strategies.front().final_right)) + "</tr>";
    rows += row;
  }
  return TableCard(
      rows, "Mean views by object with 95 % bootstrap intervals; least in bold.", "dense");
}

std::string CalibrationTable(const ConfusionResults& results) {
  std::string rows =
      HeadRow({"probability of the best hypothesis", "steps", "mean probability (%)", "right (%)"});
  for (const CalibrationBin& bin : results.calibration) {
    if (bin.count == 0) continue;
    rows += Row({HtmlCell(Format("%g to %g", bin.low, bin.high)),
                 HtmlCell(std::to_string(bin.count)),
                 HtmlCell(Percent(bin.mean_mass)),
                 HtmlCell(Percent(bin.right))});
  }
  return TableCard(rows, "Over all views of all sequences, objects and strategies.");
}

std::string TablesTable(const ConfusionResults& results) {
  std::string rows = HeadRow({"object",
                              "symmetry",
                              "directions",
                              "rows",
                              "trials",
                              "right (%)",
                              "missed (%)",
                              "modes",
                              "confused by"});
  for (const TableFacts& table : results.tables) {
    std::string confused;
    for (const ConfusedBy& one : table.confused_by) {
      if (!confused.empty()) confused += "; ";
      confused += Format("%.0f° about (%.1f, %.1f, %.1f) %.1f %%, up to %.0f %%",
                         one.angle_deg,
                         one.axis.x(),
                         one.axis.y(),
                         one.axis.z(),
                         100.0 * one.share,
                         100.0 * one.largest_share);
    }
    rows +=
        "<tr>" + HtmlCell(table.model_id) + HtmlCell(table.symmetry) +
        HtmlCell(std::to_string(table.num_directions)) + HtmlCell(std::to_string(table.num_rows)) +
        HtmlCell(std::to_string(table.num_trials)) + HtmlCell(Percent(table.right)) +
        HtmlCell(Percent(table.missed)) + HtmlCell(std::to_string(table.num_modes)) +
        "<td style=\"text-align:left;white-space:normal\">" + EscapeHtml(confused) + "</td></tr>";
  }
  return TableCard(
      rows,
      "Shares of the trials, mean over the viewing directions. Confused by: difference "
      "rotations q' = q_GT* q_D and how often, in the mean and from the direction "
      "where they are most frequent.",
      "dense");
}

std::string ReweightingHtml(const ReweightingTable& table) {
  std::vector<std::string> heads = {"object"};
  for (const MethodInfo& method : table.methods) heads.push_back(method.label);
  std::string rows = HeadRow(heads);
  for (size_t object = 0; object < table.model_ids.size(); ++object) {
    std::vector<double> medians;
    for (const auto& errors : table.final_deg[object]) {
      medians.push_back(Median(WithMissing(errors)));
    }
    std::vector<double> sorted = medians;
    std::sort(sorted.begin(), sorted.end());
    std::string row = "<tr>" + HtmlCell(table.model_ids[object]);
    for (size_t m = 0; m < medians.size(); ++m) {
      row += HtmlCell(ErrorsText(table.final_deg[object][m]),
                      medians[m] == sorted[0]   ? "first"
                      : medians[m] == sorted[1] ? "second"
                                                : "");
    }
    rows += row + "</tr>";
  }
  const size_t circles = table.final_deg.empty() ? 0 : table.final_deg[0][0].size();
  return Format("<h3>k = %d</h3>", table.k) +
         TableCard(rows,
                   Format("Final error after a circle of 30 views in degrees modulo symmetry: "
                          "median and quartiles of %zu circles. Bold: best; italic: second. AW: "
                          "accuracy weights from the contingency table by direction, summed on "
                          "cells (eq. 10). Table, kernels: the filter that knows the table, which "
                          "adds a detection at every truth that it may stand for and takes the "
                          "peak that the belief, the product over the views, finds likeliest.",
                          circles));
}

std::string PeaksTable(const ConfusionResults& results) {
  std::string rows = HeadRow({"object",
                              "weights",
                              "views",
                              "peaks",
                              "heaviest peak off (°)",
                              "its share of the peaks (%)",
                              "highest cell (%)",
                              "other peaks at (°)"});
  for (const PeakFacts& peaks : results.peaks) {
    std::string others;
    for (const double angle : peaks.others_deg) {
      others += Format("%s%.0f", others.empty() ? "" : ", ", angle);
    }
    rows += Row({HtmlCell(peaks.model_id),
                 HtmlCell(peaks.method),
                 HtmlCell(std::to_string(peaks.views)),
                 HtmlCell(std::to_string(peaks.num_peaks)),
                 HtmlCell(NumberText(peaks.best_deg, 2)),
                 HtmlCell(Percent(peaks.share_of_best)),
                 HtmlCell(Percent(peaks.highest, 2)),
                 HtmlCell(others.empty() ? "–" : others)});
  }
  return TableCard(rows,
                   "Peaks that are at least 0.3 of the highest by confidence weights (CW) and by "
                   "accuracy weights (AW, eq. 10), and those that are at least 0.3 as probable as "
                   "the best by the belief that the contingency table leaves (table); the others "
                   "by their angle to the heaviest.");
}

Result<std::string> Pictures(const ConfusionResults& results, const std::string& group) {
  std::string html;
  for (const ConfusionPicture& picture : results.pictures) {
    if (picture.group != group) continue;
    const Result<std::vector<uint8_t>> png = EncodePng(picture.image);
    if (!png) return png.error();
    html += "<figure><img alt=\"" + EscapeHtml(picture.caption) + "\" src=\"" +
            DataUri("image/png", *png) + "\"><figcaption>" + EscapeHtml(picture.caption) +
            "</figcaption></figure>";
  }
  if (html.empty()) return html;
  return "<div class=\"card pictures\">" + html + "</div>";
}

std::string RunList(const ConfusionResults& results) {
  return "<dl><dt>made by</dt><dd><code>" + EscapeHtml(results.command) +
         "</code></dd><dt>version</dt><dd>" + EscapeHtml(results.version) +
         Format(
             "</dd><dt>sequences</dt><dd>%d of each object, %d views each, from the same pose, "
             "first view and noise for every strategy; next views out of %d</dd>"
             "<dt>seed</dt><dd>%llu</dd></dl>",
             results.sequences,
             results.views,
             results.candidates,
             static_cast<unsigned long long>(results.seed));
}

std::string ViewsSections(const ConfusionResults& results, const ReportFigures& figures) {
  if (results.objects.empty()) return "";
  return Section("summary",
                 "Views until the right mode holds",
                 "",
                 BarsTable(results) + NeededTable(results) +
                     FigureCard(figures,
                                "open",
                                "share of sequences not held by views",
                                "Sequences of all objects in which the right mode does not hold "
                                "yet after so many views.") +
                     RunList(results)) +
         Section("strategies",
                 "By object",
                 "",
                 FigureCard(figures,
                            "needed",
                            "mean views by object",
                            Format("Sequences where it never holds count as %d views.",
                                   results.views + 1)) +
                     ObjectsTable(results)) +
         Section("calibration",
                 "Whether the belief can be believed",
                 "",
                 FigureCard(figures,
                            "calibration",
                            "share right by probability",
                            "How often the best hypothesis is right, by its probability; dashed: "
                            "as it should be.") +
                     CalibrationTable(results));
}

}  // namespace

Result<std::string> ConfusionPage(const ConfusionResults& results, const ReportFigures& figures) {
  std::map<std::string, std::string> pictures;
  for (const char* group : {"fig5", "fig6", "fig16", "fig17"}) {
    Result<std::string> html = Pictures(results, group);
    if (!html) return html.error();
    pictures[group] = std::move(*html);
  }
  std::string reweighting;
  for (const ReweightingTable& table : results.reweighting) reweighting += ReweightingHtml(table);
  return std::string(
             "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta "
             "name=\"viewport\" content=\"width=device-width,initial-scale=1\">"
             "<title>Measured confusion, evaluated</title><style>") +
         ReportStyle() + kPictureStyle +
         "</style></head><body><main><h1>Measured confusion, evaluated</h1><p class=\"soft\">"
         "Contingency tables of objects that look alike from several sides, and what they are good "
         "for: fusion, symmetry and the next best view (Marton et al., Autonomous Robots, 2017, "
         "section 6 and 7.4, 7.5).</p>" +
         kNavigation + ViewsSections(results, figures) +
         Section("tables", "Contingency tables", "", TablesTable(results)) +
         Section("fig5",
                 "A contingency table (Fig. 5)",
                 "Rows: ground truth orientations; columns: detected ones; ordinals of the grid's "
                 "cells at k = 8 from the left and from the top. Every pixel is the largest entry "
                 "of a block of cells; left: by the square root of the share, right: every entry "
                 "other than 0 at the maximum.",
                 pictures["fig5"]) +
         Section("fig6",
                 "Symmetry weights (Fig. 6)",
                 "How often each difference rotation q' was seen, as the point q' (1, 1, 1) on the "
                 "unit sphere, from both sides; the identity is in the middle of the left half. "
                 "Ends of the axes: x red, y green, z blue.",
                 pictures["fig6"]) +
         Section("table3", "Reweighting by the table (Table 3)", "", reweighting) +
         Section("fig16",
                 "Peaks without and with the table (Fig. 16, 17)",
                 "Histograms on a circle of views, relative to the truth, which is in the middle "
                 "of the left half.",
                 PeaksTable(results) + pictures["fig16"] + pictures["fig17"]) +
         Section("fig18",
                 "Errors view by view (Fig. 18)",
                 "",
                 FigureCard(figures,
                            "steps",
                            "errors view by view by strategy",
                            "Stars: median error of each view's own detection; line: median error "
                            "of the fused orientation (density mode); band: quartiles over the "
                            "sequences. Modulo symmetry, logarithmic.")) +
         "</main></body></html>\n";
}

Result<void> WriteConfusionReport(const ConfusionResults& results, const fs::path& folder) {
  const Result<ReportFigures> figures = DrawConfusionFigures(results);
  if (!figures) return figures.error();
  Result<std::string> page = ConfusionPage(results, *figures);
  if (!page) return page.error();
  std::vector<std::pair<std::string, std::string>> files;
  files.emplace_back("reweighting.csv", ReweightingCsv(results));
  files.emplace_back("views_needed.csv", ViewsNeededCsv(results));
  files.emplace_back("steps.csv", StepsCsv(results));
  files.emplace_back("results.json", ConfusionJson(results));
  files.emplace_back("report.html", std::move(*page));
  if (Result<void> written = WriteReportFiles(folder, *figures, files); !written) return written;
  for (const ConfusionPicture& picture : results.pictures) {
    const Result<void> written =
        WritePng(folder / "figures" / (picture.name + ".png"), picture.image);
    if (!written) return written;
  }
  return {};
}

}  // namespace vantage
