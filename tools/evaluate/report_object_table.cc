// Table 2 of the paper with ours.
#include <algorithm>
#include <cmath>

#include "common/format.h"
#include "tools/evaluate/paper_figures.h"
#include "tools/evaluate/report_exhibits.h"
#include "tools/evaluate/report_numbers.h"
#include "tools/support/html.h"

namespace vantage {
namespace {

// The least of the values and the next one above it; infinite where there is none.
struct Leaders {
  double first = INFINITY;
  double second = INFINITY;

  explicit Leaders(const std::vector<double>& values) {
    for (const double value : values) {
      if (value < first) {
        second = first;
        first = value;
      } else if (value > first && value < second) {
        second = value;
      }
    }
  }
  [[nodiscard]] const char* Class(double value) const {
    return value == first ? "first" : value == second ? "second" : "";
  }
};

std::string PaperRow(const EvaluationResults& results, const PaperObject& paper) {
  std::string row = "<tr class=\"paper\">" + HtmlCell("paper") +
                    HtmlCell(CompactText(paper.median_detection_deg));
  const Leaders leaders({paper.final_deg.begin(), paper.final_deg.end()});
  for (const MethodInfo& method : results.methods) {
    const int column = PaperColumn(method.id);
    if (column < 0) {
      row += HtmlCell("");
      continue;
    }
    const double error = paper.final_deg[static_cast<size_t>(column)];
    row += HtmlCell(CompactText(error), leaders.Class(error));
  }
  return row + "</tr>";
}

std::vector<double> Finals(const CircleErrors& object, bool symmetric) {
  std::vector<double> finals;
  for (const std::vector<double>& steps : symmetric ? object.step_symmetric_deg : object.step_deg) {
    finals.push_back(FinalError(steps));
  }
  return finals;
}

std::string ObjectTable(const EvaluationResults& results, bool symmetric, const char* note) {
  std::string rows = "<tr>" + HeadCell("object") + HeadCell("median detection");
  for (const MethodInfo& method : results.methods) {
    rows += HeadCell(MethodName(method), method.is_histogram ? "ours" : "");
  }
  rows += "</tr>";
  for (const CircleErrors& object : results.circle) {
    const std::vector<double> detections =
        Finite(symmetric ? object.detection_symmetric_deg : object.detection_deg);
    const std::vector<double> finals = Finals(object, symmetric);
    const Leaders leaders(finals);
    rows += "<tr><td title=\"" + EscapeHtml(object.symmetry) + "\">" + EscapeHtml(object.model_id) +
            "</td>" + HtmlCell(detections.empty() ? "–" : CompactText(Median(detections)));
    for (const double error : finals) rows += HtmlCell(CompactText(error), leaders.Class(error));
    rows += "</tr>";
    const PaperObject* paper = FindPaperObject(object.model_id);
    if (paper != nullptr) rows += PaperRow(results, *paper);
  }
  return TableCard(rows, note, "dense");
}

// On how many objects a method of ours has the least error.
std::string ObjectsSentence(const EvaluationResults& results) {
  size_t ours = 0;
  size_t below_tenth = 0;
  const std::optional<size_t> best = BestOurs(results);
  for (const CircleErrors& object : results.circle) {
    const std::vector<double> finals = Finals(object, true);
    const Leaders leaders(finals);
    bool leads = false;
    for (size_t i = 0; i < finals.size(); ++i) {
      leads = leads || (results.methods[i].is_histogram && finals[i] == leaders.first);
    }
    if (leads) ++ours;
    if (best && finals[*best] < 0.1) ++below_tenth;
  }
  std::string text = Format(
      "Modulo symmetry, one of our variants has the least error on %zu of %zu "
      "objects",
      ours,
      results.circle.size());
  if (best) {
    text += Format(
        "; %s is below 0.1° on %zu", MethodName(results.methods[*best]).c_str(), below_tenth);
  }
  return text + " (paper: histogram filters lead on 16 of 18).";
}

}  // namespace

std::string ObjectsSection(const EvaluationResults& results) {
  const char* title = "All objects on the circle of views (Table 2)";
  if (results.circle.empty()) {
    return Section("objects", title, "No views on the circle were computed.", "");
  }
  return Section(
      "objects",
      title,
      ObjectsSentence(results),
      "<h3>Modulo symmetry</h3>" +
          ObjectTable(
              results,
              true,
              "Error of the final orientation after all views, degrees, modulo symmetry. Least "
              "of a row bold, next italic; a dash where there is no estimate. The paper's "
              "row, where it has an object of the same name (another shape, "
              "estimator and camera), is plain.") +
          "<h3>Plain</h3>" +
          ObjectTable(
              results,
              false,
              "The same, plain as in the paper: a turn onto an equal look counts as an error."));
}

}  // namespace vantage
