#include "tools/evaluate/report_exhibits.h"

#include <algorithm>
#include <cmath>

#include "common/format.h"
#include "tools/evaluate/figure_grid.h"
#include "tools/evaluate/figure_steps.h"
#include "tools/evaluate/figure_style.h"
#include "tools/evaluate/paper_figures.h"
#include "tools/evaluate/report_numbers.h"

namespace vantage {
namespace {

constexpr const char* kNoCircle = "No views on the circle were computed.";

std::string GridTable(const EvaluationResults& results) {
  std::string rows = "<tr>" + HeadCell("k") + HeadCell("N") + HeadCell("N, paper") +
                     HeadCell("mean of d_nn (°)") + HeadCell("paper") + HeadCell("difference") +
                     HeadCell("deviation (°)") + HeadCell("paper") + HeadCell("difference") +
                     HeadCell("memory (MB)") + HeadCell("paper") + HeadCell("built in (s)") +
                     "</tr>";
  for (const GridStatistics& grid : results.grids) {
    const PaperGrid* paper = FindPaperGrid(grid.k);
    const auto cell = [&](double value, int decimals) {
      return HtmlCell(paper == nullptr ? "–" : NumberText(value, decimals), "soft");
    };
    const PaperGrid none;
    const PaperGrid& theirs = paper == nullptr ? none : *paper;
    rows += "<tr>" + HtmlCell(std::to_string(grid.k)) + HtmlCell(std::to_string(grid.num_cells)) +
            cell(static_cast<double>(theirs.num_cells), 0) +
            HtmlCell(NumberText(grid.mean_deg, 2)) + cell(theirs.mean_deg, 2) +
            cell(grid.mean_deg - theirs.mean_deg, 2) + HtmlCell(NumberText(grid.deviation_deg, 2)) +
            cell(theirs.deviation_deg, 2) + cell(grid.deviation_deg - theirs.deviation_deg, 2) +
            HtmlCell(NumberText(grid.megabytes, grid.megabytes < 10.0 ? 2 : 0)) +
            cell(theirs.megabytes, 0) + HtmlCell(NumberText(grid.build_seconds, 2)) + "</tr>";
  }
  return TableCard(rows,
                   "Table 1. d_nn: angle between a representative orientation and its nearest "
                   "neighbor, over all N. Memory: the grid and a histogram with a weight in every "
                   "cell; the paper's figures are approximate.");
}

std::string GridSentence(const EvaluationResults& results) {
  int same = 0;
  int known = 0;
  double farthest = 0.0;
  for (const GridStatistics& grid : results.grids) {
    const PaperGrid* paper = FindPaperGrid(grid.k);
    if (paper == nullptr) continue;
    ++known;
    if (grid.num_cells == paper->num_cells) ++same;
    farthest = std::max(farthest, std::abs(grid.mean_deg - paper->mean_deg));
  }
  std::string text;
  if (known > 0) {
    text = Format(
        "The number of orientations is the paper's at %d of %d k; the means of d_nn differ "
        "from the paper's by %.2f° at most.",
        same,
        known,
        farthest);
  }
  const std::vector<int64_t>& counts = results.grid_angles.counts;
  if (counts.empty()) return text;
  const std::vector<double> expected = UniformAngleCounts(results.grid_angles);
  double distance = 0.0;
  double total = 0.0;
  for (size_t i = 0; i < counts.size(); ++i) {
    distance += 0.5 * std::abs(static_cast<double>(counts[i]) - expected[i]);
    total += expected[i];
  }
  if (total <= 0.0) return text;
  return text + Format(
                    " Of the angles, %.1f %% would have to lie in another bin to follow "
                    "sin²(θ/2).",
                    100.0 * distance / total);
}

// NaN where the sweep has no such point.
double SweepError(const ClusteringSweep& sweep, double w_min, double w_max) {
  for (size_t i = 0; i < sweep.w_min.size(); ++i) {
    for (size_t j = 0; j < sweep.w_max.size(); ++j) {
      if (std::abs(sweep.w_min[i] - w_min) < 1e-6 && std::abs(sweep.w_max[j] - w_max) < 1e-6) {
        return sweep.mean_error_deg[i][j];
      }
    }
  }
  return NAN;
}

std::string SweepSentence(const ClusteringSweep& sweep) {
  double least = NAN;
  std::string text;
  for (size_t i = 0; i < sweep.w_min.size(); ++i) {
    for (size_t j = 0; j < sweep.w_max.size(); ++j) {
      const double error = sweep.mean_error_deg[i][j];
      if (!std::isfinite(error) || error >= least) continue;
      least = error;
      text = Format("The least mean error is %.3f° at w_min = %g, w_max = %g",
                    error,
                    sweep.w_min[i],
                    sweep.w_max[j]);
    }
  }
  if (text.empty()) return "No mean error is known.";
  const double best = SweepError(sweep, kPaperSweepBest.w_min, kPaperSweepBest.w_max);
  const double worst = SweepError(sweep, kPaperSweepWorst.w_min, kPaperSweepWorst.w_max);
  if (std::isfinite(best)) {
    text += Format("; at the paper's choice, %g and %g, it is %.3f° (paper: at most %g°)",
                   kPaperSweepBest.w_min,
                   kPaperSweepBest.w_max,
                   best,
                   kPaperSweepBest.mean_error_deg);
  }
  if (std::isfinite(worst)) {
    text += Format("; at %g and %g it is %.3f° (paper: about %g°)",
                   kPaperSweepWorst.w_min,
                   kPaperSweepWorst.w_max,
                   worst,
                   kPaperSweepWorst.mean_error_deg);
  }
  return text + ".";
}

std::string StepsSentence(const EvaluationResults& results) {
  const std::optional<size_t> best = BestOurs(results);
  if (!best) return "";
  std::string text = "After the last view, " + MethodName(results.methods[*best]) + " is off by ";
  std::vector<std::string> parts;
  for (const size_t index : StepObjects(results)) {
    const CircleErrors& object = results.circle[index];
    std::string part =
        NumberText(FinalError(object.step_symmetric_deg[*best])) + "° on " + object.model_id;
    std::vector<std::string> others;
    for (const char* id : {kKnnId, kParticleFilterId, kBinghamProductId, kBinghamParticlesId}) {
      const std::optional<size_t> method = FindMethod(results, id);
      if (!method) continue;
      const bool runs = id == kParticleFilterId && !object.particle_runs_deg.empty();
      const double error = FinalError(runs ? MeanOfRuns(object.particle_runs_deg)
                                           : object.step_symmetric_deg[*method]);
      others.push_back(MethodName(results.methods[*method]) + " " + NumberText(error) + "°");
    }
    parts.push_back(others.empty() ? part : part + " (" + ListText(others) + ")");
  }
  return text + ListText(parts) + ".";
}

std::string BoxesTable(const EvaluationResults& results) {
  std::string rows = "<tr>" + HeadCell("method") + HeadCell("median (°)") + HeadCell("quartiles") +
                     HeadCell("modulo symmetry: median (°)") + HeadCell("quartiles") +
                     HeadCell("paper's text: median (°)") + HeadCell("quartiles") +
                     HeadCell("paper's Table 2: median (°)") + "</tr>";
  for (size_t i = 0; i < results.methods.size(); ++i) {
    const MethodInfo& method = results.methods[i];
    rows += "<tr><td>" + MethodHtml(method) + "</td>";
    for (const bool symmetric : {false, true}) {
      const BoxSummary box = SummarizeBox(WithMissing(CircleFinals(results, i, symmetric)));
      rows += HtmlCell(NumberText(box.median)) +
              HtmlCell(NumberText(box.lower_quartile) + " – " + NumberText(box.upper_quartile));
    }
    const PaperBox* paper = FindPaperBox(method.id);
    const bool quartiles = paper != nullptr && std::isfinite(paper->lower_quartile_deg);
    rows += HtmlCell(paper == nullptr ? "–"
                     : paper->median_low_deg == paper->median_high_deg
                         ? Format("%g", paper->median_low_deg)
                         : Format("%g to %g", paper->median_low_deg, paper->median_high_deg),
                     "soft");
    rows += HtmlCell(
        quartiles ? Format("%g – %g", paper->lower_quartile_deg, paper->upper_quartile_deg) : "–",
        "soft");
    const int column = PaperColumn(method.id);
    std::vector<double> theirs;
    for (const PaperObject& object : PaperObjects()) {
      if (column >= 0) theirs.push_back(object.final_deg[static_cast<size_t>(column)]);
    }
    rows += HtmlCell(theirs.empty() ? "–" : NumberText(Median(theirs)), "soft") + "</tr>";
  }
  return TableCard(rows,
                   "Medians and quartiles over the objects. The paper's text (7.3.2) gives rounded "
                   "figures, its quartiles after it had left outliers out; the last column is "
                   "the median of its Table 2.",
                   "dense");
}

std::string BoxesSentence(const EvaluationResults& results) {
  const std::optional<size_t> best = BestOurs(results);
  std::vector<std::string> parts;
  for (size_t i = 0; i < results.methods.size(); ++i) {
    const PaperBox* paper = FindPaperBox(results.methods[i].id);
    if (paper == nullptr && i != best) continue;
    const double median = Median(WithMissing(CircleFinals(results, i, true)));
    std::string part = MethodName(results.methods[i]) + " " + NumberText(median) + "°";
    if (paper != nullptr) {
      part += paper->median_low_deg == paper->median_high_deg
                  ? Format(" (paper: %g°)", paper->median_low_deg)
                  : Format(" (paper: %g° to %g°)", paper->median_low_deg, paper->median_high_deg);
    }
    parts.push_back(part);
  }
  return parts.empty() ? "" : "Medians over the objects, modulo symmetry: " + ListText(parts) + ".";
}

std::string ViewsSentence(const EvaluationResults& results) {
  const std::optional<size_t> best = BestOurs(results);
  if (!best) return "";
  size_t better = 0;
  size_t settled = 0;
  const CircleErrors* worst = nullptr;
  for (const CircleErrors& object : results.circle) {
    const std::vector<double>& steps = object.step_symmetric_deg[*best];
    const std::vector<double> detections = Finite(object.detection_symmetric_deg);
    const double error = FinalError(steps);
    if (!detections.empty() && error < Median(detections)) ++better;
    const size_t half = steps.size() / 2;
    const bool all_right = std::all_of(steps.begin() + static_cast<std::ptrdiff_t>(half),
                                       steps.end(),
                                       [](double step) { return step < 1.0; });
    if (!steps.empty() && all_right) ++settled;
    if (worst == nullptr || error > FinalError(worst->step_symmetric_deg[*best])) worst = &object;
  }
  return Format(
             "The final orientation (%s) is better than the median detection on %zu of %zu "
             "objects, and under 1° during the whole second half of the views on %zu; "
             "farthest off at the end: ",
             MethodName(results.methods[*best]).c_str(),
             better,
             results.circle.size(),
             settled) +
         worst->model_id + ", " + NumberText(FinalError(worst->step_symmetric_deg[*best])) + "°.";
}

}  // namespace

std::string GridSection(const EvaluationResults& results, const ReportFigures& figures) {
  if (results.grids.empty() && results.grid_angles.counts.empty()) {
    return Section("grid", "Grid of orientations (Table 1, Fig. 4)", "No grid was measured.", "");
  }
  return Section(
      "grid",
      "Grid of orientations (Table 1, Fig. 4)",
      GridSentence(results),
      (results.grids.empty() ? "" : GridTable(results)) +
          FigureCard(figures,
                     "grid",
                     "histograms of angles and neighbor distances",
                     "Fig. 4, k = 32. Left: angles of the representative orientations; the "
                     "curve is what an even spread would count. Right: distance of every "
                     "representative to its nearest neighbor."));
}

std::string SweepSection(const EvaluationResults& results, const ReportFigures& figures) {
  const char* title = "Parameters of clustering (Fig. 8)";
  if (!figures.contains("sweep")) return Section("sweep", title, "No parameters were swept.", "");
  return Section(
      "sweep",
      title,
      SweepSentence(results.sweep),
      FigureCard(figures,
                 "sweep",
                 "mean error and wrong-mode rate by w_min and w_max",
                 "Mean error of the final orientation, modulo symmetry, and share of wrong "
                 "modes, for every w_min not above w_max; darker is more, on a logarithmic "
                 "scale. Frame: the least mean error; dashed frame: the paper's choice."));
}

std::string StepsSection(const EvaluationResults& results, const ReportFigures& figures) {
  const char* title = "Three objects step by step (Fig. 10)";
  if (results.circle.empty()) return Section("steps", title, kNoCircle, "");
  return Section("steps",
                 title,
                 StepsSentence(results),
                 FigureCard(figures,
                            "steps",
                            "errors of three objects view by view",
                            Format("Errors modulo symmetry after so many views on the circle; "
                                   "stars: every view's own detection; thin line: mean of their "
                                   "errors so far; pale lines: single runs of the particle filter. "
                                   "Logarithmic; errors below %g° are drawn there.",
                                   kSmallestDrawnDeg)));
}

std::string BoxesSection(const EvaluationResults& results, const ReportFigures& figures) {
  const char* title = "Box plots by method (Fig. 14)";
  if (results.circle.empty()) return Section("boxes", title, kNoCircle, "");
  const std::string note = Format(
      " Boxes: quartiles; strong line: median; whiskers: outermost values within 1.5 "
      "interquartile distances; circles: values beyond; orange diamonds: the medians that the "
      "paper's "
      "text gives. No estimate counts as %g°. *: not in the paper.",
      kMissingErrorDeg);
  return Section("boxes",
                 title,
                 BoxesSentence(results),
                 FigureCard(figures,
                            "boxes",
                            "box plots modulo symmetry",
                            "Final errors over the objects, modulo symmetry." + note) +
                     FigureCard(figures,
                                "boxes_plain",
                                "box plots of plain errors",
                                "The same, plain as in the paper." + note) +
                     BoxesTable(results));
}

std::string ViewsSection(const EvaluationResults& results, const ReportFigures& figures) {
  const char* title = "All objects view by view (Fig. 15)";
  if (results.circle.empty()) return Section("views", title, kNoCircle, "");
  return Section("views",
                 title,
                 ViewsSentence(results),
                 FigureCard(figures,
                            "objects",
                            "errors of all objects view by view",
                            "Stars: every view's own detection; line: the final orientation of all "
                            "views so far. Modulo symmetry, logarithmic, the same axes for all."));
}

}  // namespace vantage
