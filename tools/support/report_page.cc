#include "tools/support/report_page.h"

#include <algorithm>

#include "common/format.h"
#include "tools/support/color.h"
#include "tools/support/error_figure.h"
#include "tools/support/html.h"
#include "tools/support/report_pictures.h"
#include "tools/support/view_choice_figure.h"

namespace vantage {
namespace {

constexpr const char* kStyle = R"(
:root { color-scheme: light; --ink:#1d2733; --soft:#5c6a7a; --line:#dfe4ea; --good:#1a7f4b; --bad:#b3261e; }
* { box-sizing: border-box; }
body { margin:0; font:16px/1.55 system-ui,sans-serif; color:var(--ink); background:#f5f7f9; }
main { max-width:1120px; margin:0 auto; padding:24px 18px 60px; }
h1 { font-size:1.7rem; margin:.2em 0; } h2 { font-size:1.2rem; margin:2em 0 .6em; }
p { max-width:75ch; } .soft { color:var(--soft); }
.card { background:#fff; border:1px solid var(--line); border-radius:10px; padding:16px; overflow-x:auto; }
table { border-collapse:collapse; width:100%; font-variant-numeric:tabular-nums; }
th,td { text-align:right; padding:6px 10px; border-bottom:1px solid var(--line); white-space:nowrap; }
th:first-child,td:first-child { text-align:left; } tr:last-child td { border-bottom:0; }
th { color:var(--soft); font-weight:600; font-size:.9rem; }
img { max-width:100%; height:auto; display:block; border-radius:6px; }
.wide { width:100%; min-width:600px; max-width:none; }
.grid { display:grid; gap:16px; grid-template-columns:repeat(auto-fill,minmax(min(100%,330px),1fr)); }
.pair { display:grid; gap:16px; grid-template-columns:repeat(auto-fit,minmax(min(100%,450px),1fr)); }
.dot { display:inline-block; width:.75em; height:.75em; border-radius:50%; margin-right:.5em; }
.verdict { font-weight:600; } .met { color:var(--good); } .missed { color:var(--bad); }
figure table { font-size:.85rem; } figure th,figure td { padding:4px 5px; }
figcaption { color:var(--soft); font-size:.92rem; margin-top:.5em; } figure { margin:0; }
)";

Result<std::string> Picture(const RgbImage& image, const std::string& alternative) {
  const Result<std::vector<uint8_t>> png = EncodePng(image);
  if (!png) return png.error();
  return Format("<img alt=\"%s\" src=\"", EscapeHtml(alternative).c_str()) +
         DataUri("image/png", *png) + "\">";
}

std::string Dot(const RecordedRun& run, const std::optional<int32_t>& instance) {
  if (!instance) return "";
  return "<span class=\"dot\" style=\"background:" +
         HexColor(ObjectColor(ColorIndex(run, *instance))) + "\"></span>";
}

// Of metrics.objects; grey where the run has no estimate.
std::vector<Rgb> ObjectColors(const RecordedRun& run, const RunMetrics& metrics) {
  std::vector<Rgb> colors;
  for (const ObjectHistory& object : metrics.objects) {
    colors.push_back(object.instance ? ObjectColor(ColorIndex(run, *object.instance))
                                     : Rgb{128, 128, 128});
  }
  return colors;
}

std::string Cell(const std::optional<PoseError>& error, bool angle) {
  if (!error) return "<td>–</td>";
  return angle ? Format("<td>%.2f°</td>", error->angle / kDegree)
               : Format("<td>%.2f mm</td>", 1e3 * error->distance);
}

std::string Summary(const RecordedRun& run, const RunMetrics& metrics, const ReportLimits& limits) {
  std::string html =
      "<div class=\"card\"><table><tr><th>object</th><th>error</th><th>position error</th>"
      "<th>refined</th><th>refined position</th><th>median single "
      "view</th><th>views</th><th>seconds</th></tr>";
  for (const ObjectHistory& object : metrics.objects) {
    const std::optional<PoseError> error = object.final_error();
    const std::optional<double> median = object.median_detection_angle();
    html += "<tr><td>" + Dot(run, object.instance) + EscapeHtml(object.model_id);
    if (!object.instance) html += " <span class=\"missed\">not found</span>";
    const std::optional<PoseError> refined = object.final_refined_error();
    html += "</td>" + Cell(error, true) + Cell(error, false) + Cell(refined, true) +
            Cell(refined, false);
    html += median ? Format("<td>%.2f°</td>", *median / kDegree) : std::string("<td>–</td>");
    html += Format("<td>%d</td><td>%.1f</td></tr>", object.num_views, object.seconds);
  }
  html += "</table></div>";
  for (const std::string& extra : metrics.extra) {
    html += "<p class=\"missed\">" + EscapeHtml(extra) + " was reported but is not there.</p>";
  }
  const bool met = metrics.Within(limits.rotation_deg * kDegree, 1e-3 * limits.position_mm);
  html += Format(
      "<p class=\"verdict %s\">Every object within %.3g° modulo its symmetry and %.3g mm: %s.</p>",
      met ? "met" : "missed",
      limits.rotation_deg,
      limits.position_mm,
      met ? "yes" : "no");
  return html;
}

// Why the camera went where it went then.
Result<std::string> ViewChoice(const next_view_t& decision, size_t index) {
  const Result<std::string> figure = ViewChoiceFigure(decision);
  if (!figure || figure->empty()) return figure;
  return Format("<img alt=\"candidates after view %zu\" src=\"", index + 1) +
         DataUri("image/svg+xml", *figure) + "\"><figcaption>" +
         EscapeHtml(RejectionText(decision)) + "</figcaption>";
}

Result<std::string> ViewCard(const RecordedRun& run,
                             size_t index,
                             const ReportSetup& setup,
                             const RunMetrics& metrics) {
  const RunView& view = run.views[index];
  std::string html = "<figure class=\"card\">";
  if (view.depth.width > 0 && run.camera && run.camera->width == view.depth.width &&
      run.camera->height == view.depth.height) {
    const Result<std::string> picture =
        Picture(ViewPicture(run, view, setup), Format("depth of view %zu", index + 1));
    if (!picture) return picture.error();
    html += *picture;
  }
  html += Format("<figcaption><b>View %zu.</b> %s</figcaption>",
                 index + 1,
                 view.next_view.reason.empty()
                     ? ""
                     : EscapeHtml("Then: " + view.next_view.reason + ".").c_str());
  html += "<table><tr><th></th><th>alone</th><th>fused</th><th></th><th>refined</th></tr>";
  for (const ObjectHistory& object : metrics.objects) {
    if (index >= object.fused.size()) continue;
    html += "<tr><td>" + Dot(run, object.instance) + EscapeHtml(object.model_id) + "</td>" +
            Cell(object.detected[index], true) + Cell(object.fused[index], true) +
            Cell(object.fused[index], false) +
            Cell(index < object.refined.size() ? object.refined[index] : std::nullopt, true) +
            "</tr>";
  }
  html += "</table>";
  const Result<std::string> choice = ViewChoice(view.next_view, index);
  if (!choice) return choice.error();
  return html + *choice + "</figure>";
}

Result<std::string> Scene(const RecordedRun& run, const ReportSetup& setup) {
  const Result<std::string> near =
      Picture(ScenePicture(run, setup, SceneCut::kObjects), "the objects");
  if (!near) return near.error();
  const Result<std::string> wide =
      Picture(ScenePicture(run, setup, SceneCut::kCameras), "the camera's way round the objects");
  if (!wide) return wide.error();
  return "<h2>What was found</h2><div class=\"pair\"><figure class=\"card\">" + *near +
         "<figcaption>The objects at their estimated poses.</figcaption></figure>"
         "<figure class=\"card\">" +
         *wide +
         "<figcaption>Where the camera looked from, and its way.</figcaption></figure></div>";
}

// First, middle and last view with a histogram of the object.
std::vector<size_t> HistogramViews(const RecordedRun& run, int32_t instance) {
  std::vector<size_t> with;
  for (size_t i = 0; i < run.views.size(); ++i) {
    if (run.views[i].histograms.contains(instance)) with.push_back(i);
  }
  if (with.size() <= 3) return with;
  return {with.front(), with[with.size() / 2], with.back()};
}

Result<std::string> Histograms(const RecordedRun& run, const RunMetrics& metrics) {
  std::string html;
  for (const ObjectHistory& object : metrics.objects) {
    if (!object.instance) continue;
    for (const size_t view : HistogramViews(run, *object.instance)) {
      const Result<std::string> picture =
          Picture(HistogramPicture(run.views[view].histograms.at(*object.instance),
                                   HistogramSide(run, *object.instance)),
                  "orientation histogram of " + object.model_id);
      if (!picture) return picture.error();
      html += "<figure class=\"card\">" + *picture + "<figcaption>" + Dot(run, object.instance) +
              EscapeHtml(object.model_id) +
              Format(", after view %zu</figcaption></figure>", view + 1);
    }
  }
  return html;
}

}  // namespace

Result<std::string> ReportPage(const std::string& title,
                               const RecordedRun& run,
                               const ReportSetup& setup,
                               const RunMetrics& metrics,
                               const ReportLimits& limits) {
  std::string html =
      "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
      "content=\"width=device-width,initial-scale=1\"><title>" +
      EscapeHtml(title) + "</title><style>" + kStyle + "</style></head><body><main><h1>" +
      EscapeHtml(title) + "</h1>" +
      Format(
          "<p class=\"soft\">%zu viewpoints. Angles are taken modulo each object's symmetry, "
          "distances between the models' centers.</p>",
          run.views.size());
  if (!run.damage.empty()) {
    html += "<p class=\"missed\">The log is damaged: " + EscapeHtml(run.damage) + "</p>";
  }
  if (!setup.truth.empty()) html += Summary(run, metrics, limits);

  const Result<std::string> scene = Scene(run, setup);
  if (!scene) return scene.error();
  html += *scene;
  if (!setup.truth.empty() && !metrics.objects.empty()) {
    const Result<std::string> figure = ErrorFigure(metrics, ObjectColors(run, metrics));
    if (!figure) return figure.error();
    if (!figure->empty()) {
      html +=
          "<h2>Error by view</h2><figure class=\"card\"><img class=\"wide\" alt=\"error by view\" "
          "src=\"" +
          DataUri("image/svg+xml", *figure) +
          "\"><figcaption>Circles: what a view says by itself. Lines: all views so far, fused. "
          "Dashed: refined on the depth of all of them.</figcaption></figure>";
    }
  }
  const Result<std::string> histograms = Histograms(run, metrics);
  if (!histograms) return histograms.error();
  html +=
      "<h2>Orientation histograms</h2><p class=\"soft\">Each orientation of the histogram turns "
      "the vector (1, 1, 1); the color tells how much weight arrives at a place of the sphere, "
      "from none (grey) to the most (blue). Left the near side, right the far side; red, green "
      "and blue ends mark x, y and z.</p><div class=\"grid\">" +
      *histograms + "</div>";
  html +=
      "<h2>Views</h2><p class=\"soft\">Depth in false color, near is light; outlines are the "
      "fused estimates after the view. Beside each object the error of this view alone, and that "
      "of "
      "all views so far. The map shows what was considered for the next view, straight down in the "
      "middle, level views at the rim: the darker the more it promises, crosses where it was "
      "rejected, a ring around the one chosen.</p><div class=\"grid\">";
  for (size_t i = 0; i < run.views.size(); ++i) {
    const Result<std::string> card = ViewCard(run, i, setup, metrics);
    if (!card) return card.error();
    html += *card;
  }
  return html + "</div></main></body></html>\n";
}

}  // namespace vantage
