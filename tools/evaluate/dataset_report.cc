#include "tools/evaluate/dataset_report.h"

#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "common/format.h"
#include "tools/evaluate/dataset_text.h"
#include "tools/evaluate/report_files.h"
#include "tools/evaluate/report_html.h"
#include "tools/support/color.h"
#include "tools/support/depth_view.h"
#include "tools/support/html.h"
#include "tools/support/png_image.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

constexpr Rgb kRight = {26, 127, 75};
constexpr Rgb kWrong = {200, 30, 40};
constexpr Rgb kNotFound = {240, 150, 30};

// Beside the style of all reports.
constexpr const char* kPictureStyle =
    ".views { display:grid; grid-template-columns:repeat(auto-fill,minmax(220px,1fr)); gap:12px; }"
    ".views figure { margin:0; } .views img { width:100%; display:block; border-radius:6px; }"
    ".views figcaption { font-size:.8rem; }";

std::string NumberCell(double value, int decimals) {
  return HtmlCell(std::isfinite(value) ? Format("%.*f", decimals, value) : "–");
}

std::string CountCell(int count) { return HtmlCell(std::to_string(count)); }

std::string SummaryTable(const DatasetResults& results) {
  std::string rows = "<tr>";
  for (const char* head : {"dataset",
                           "estimator",
                           "searched",
                           "objects",
                           "found",
                           "within",
                           "indistinguishable",
                           "succeeded",
                           "wrong detections",
                           "median error, deg",
                           "largest, deg",
                           "median error, mm",
                           "median time, ms",
                           "longest, ms"}) {
    rows += HeadCell(head);
  }
  rows += "</tr>";
  for (const DatasetSummary& summary : Summarize(results)) {
    rows +=
        "<tr>" + HtmlCell(results.datasets[summary.dataset].name) + HtmlCell(summary.estimator) +
        HtmlCell(Name(summary.search)) + CountCell(summary.num_objects) +
        CountCell(summary.num_found) + CountCell(summary.num_within) +
        CountCell(summary.num_indistinguishable) + CountCell(summary.num_succeeded) +
        CountCell(summary.num_wrong) + NumberCell(summary.median_angle / kDegree, 2) +
        NumberCell(summary.largest_angle / kDegree, 2) +
        NumberCell(1e3 * summary.median_distance, 2) + NumberCell(1e3 * summary.median_seconds, 1) +
        NumberCell(1e3 * summary.largest_seconds, 1) + "</tr>";
  }
  const std::string note = Format(
      "Within: %g deg and %g %% of the diameter of the truth, modulo the object's symmetry. "
      "Indistinguishable: a camera would see the same in the true and in the estimated pose, but "
      "for its noise. One of both is success. Wrong detections are those that are right for no "
      "object of their model. Times are of one image on one core.",
      results.bounds.max_angle / kDegree,
      100.0 * results.bounds.max_distance);
  return TableCard(rows, note);
}

std::string Caption(const DatasetResults& results, const DatasetOutcome& outcome) {
  const Dataset& dataset = results.datasets[outcome.dataset];
  const DatasetView& view = dataset.views[outcome.view];
  const std::string& model = dataset.models[view.objects[outcome.object].model].id;
  std::string text =
      view.name + ", " + model + ", " + outcome.estimator + ", " + Name(outcome.search) + ": ";
  if (!outcome.is_found) return text + "not found";
  const PoseSuccess& success = outcome.success;
  text += success.is_within              ? "within"
          : success.is_indistinguishable ? "indistinguishable"
                                         : "wrong";
  return text + Format(", %.2f deg, %.2f mm, score %.2f",
                       success.angle / kDegree,
                       1e3 * success.distance,
                       outcome.score);
}

Result<std::string> Picture(const DatasetResults& results, const DatasetOutcome& outcome) {
  constexpr int kWidth = 320;   // px
  constexpr int kHeight = 240;  // px
  const Dataset& dataset = results.datasets[outcome.dataset];
  const DatasetView& view = dataset.views[outcome.view];
  const DatasetObject& object = view.objects[outcome.object];
  OutlinedModel model;
  model.mesh = &dataset.models[object.model].mesh;
  model.T_camera_mesh = outcome.is_found ? outcome.T_camera_object : object.T_camera_object;
  model.color = !outcome.is_found ? kNotFound : outcome.success.succeeded() ? kRight : kWrong;
  const DepthView drawn = DrawDepthView(view.depth, view.camera, {model}, kWidth, kHeight);
  const Result<std::vector<uint8_t>> png = EncodePng(drawn.image);
  if (!png) return png.error();
  const std::string caption = EscapeHtml(Caption(results, outcome));
  return "<figure><img alt=\"" + caption + "\" src=\"" + DataUri("image/png", *png) +
         "\"><figcaption>" + caption + "</figcaption></figure>";
}

Result<std::string> DatasetSection(const DatasetResults& results, size_t index) {
  const Dataset& dataset = results.datasets[index];
  std::string content;
  for (const std::string& note : dataset.notes) {
    content += "<p class=\"note\">" + EscapeHtml(note) + "</p>";
  }
  content += "<div class=\"card views\">";
  for (const DatasetOutcome& outcome : results.outcomes) {
    if (outcome.dataset != index) continue;
    const Result<std::string> picture = Picture(results, outcome);
    if (!picture) return picture.error();
    content += *picture;
  }
  return Section(Format("dataset%zu", index), dataset.name, dataset.what, content + "</div>");
}

std::string RunSection(const DatasetResults& results) {
  std::string content = "<dl><dt>command</dt><dd><code>" + EscapeHtml(results.command) +
                        "</code></dd><dt>version</dt><dd>" + EscapeHtml(results.version) +
                        "</dd><dt>seed</dt><dd>" + std::to_string(results.seed) + "</dd></dl>";
  for (const std::string& note : results.notes) {
    content += "<p class=\"note\">" + EscapeHtml(note) + "</p>";
  }
  return Section("run", "Run", "", content);
}

}  // namespace

Result<std::string> DatasetPage(const DatasetResults& results) {
  std::string page =
      std::string(
          "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta "
          "name=\"viewport\" content=\"width=device-width,initial-scale=1\">"
          "<title>Single views of real data, evaluated</title><style>") +
      ReportStyle() + kPictureStyle +
      "</style></head><body><main><h1>Single views of real data, evaluated</h1>" +
      Section("summary",
              "Summary",
              "Each object is looked for in the whole image with all models, and in its own pixels "
              "with its own model, where they are known.",
              SummaryTable(results)) +
      RunSection(results);
  for (size_t i = 0; i < results.datasets.size(); ++i) {
    const Result<std::string> section = DatasetSection(results, i);
    if (!section) return section.error();
    page += *section;
  }
  page +=
      "<p class=\"note\">Outlines: green where the estimated pose is right, red where it is wrong, "
      "orange the true pose where nothing was found.</p></main></body></html>\n";
  return page;
}

Result<void> WriteDatasetReport(const DatasetResults& results, const fs::path& folder) {
  const Result<std::string> page = DatasetPage(results);
  if (!page) return page.error();
  return WriteReportFiles(folder,
                          {},
                          {{"report.html", *page},
                           {"views.csv", DatasetCsv(results)},
                           {"results.json", DatasetJson(results)}});
}

}  // namespace vantage
