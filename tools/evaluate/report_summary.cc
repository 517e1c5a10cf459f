#include "tools/evaluate/report_summary.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/format.h"
#include "tools/evaluate/report_numbers.h"
#include "tools/support/html.h"

namespace vantage {
namespace {

std::string Entry(const char* term, const std::string& html) {
  return std::string("<dt>") + term + "</dt><dd>" + html + "</dd>";
}

size_t NumSequences(const EvaluationResults& results) {
  size_t count = 0;
  for (const SequenceErrors& object : results.sequences) {
    if (!object.final_deg.empty()) count += object.final_deg.front().size();
  }
  return count;
}

// How a difference to the best of ours is judged, and the class of its cell.
struct Verdict {
  const char* text = "";
  const char* css_class = "";
};

Verdict Judge(const Interval& difference) {
  if (difference.low > 0.0) return {"● worse", "worse"};
  if (difference.high < 0.0) return {"● better", "better"};
  return {"○ open", "soft"};
}

std::string AccuracyRow(const EvaluationResults& results, size_t index) {
  const MethodInfo& method = results.methods[index];
  const MethodAccuracy& accuracy = results.accuracy[index];
  const bool best = method.id == results.best_ours;
  std::string row = best ? "<tr class=\"best\">" : "<tr>";
  row += "<td>" + MethodHtml(method) + "</td>" + IntervalCell(accuracy.median_deg, 1, 3) +
         IntervalCell(accuracy.mean_deg, 1, 2) + IntervalCell(accuracy.wrong_mode_rate, 100, 1) +
         IntervalCell(accuracy.early_wrong_mode_rate, 100, 1);
  if (best) {
    row += "<td colspan=\"4\" class=\"soft\">the best of ours: differences are to this row</td>";
  } else {
    const Verdict paired = Judge(accuracy.median_difference_deg);
    const Verdict rate = Judge(accuracy.difference_of_wrong_mode_rates);
    row += IntervalCell(accuracy.median_difference_deg, 1, 3) +
           HtmlCell(paired.text, paired.css_class) +
           IntervalCell(accuracy.difference_of_wrong_mode_rates, 100, 1) +
           HtmlCell(rate.text, rate.css_class);
  }
  return row + HtmlCell(std::to_string(accuracy.num_without_estimate)) + "</tr>";
}

std::string AccuracyTable(const EvaluationResults& results) {
  std::string rows = "<tr>" + HeadCell("method") + HeadCell("median error (°)") +
                     HeadCell("mean error (°)") + HeadCell("wrong mode (%)") +
                     HeadCell(Format("after %d views (%%)", results.early_views)) +
                     HeadCell("paired difference (°)") + HeadCell("") +
                     HeadCell("wrong mode, difference (points)") + HeadCell("") +
                     HeadCell("no estimate") + "</tr>";
  for (size_t i = 0; i < results.accuracy.size(); ++i) rows += AccuracyRow(results, i);
  return TableCard(
      rows,
      "Errors of the final orientation modulo symmetry, with 95 % bootstrap intervals. Paired "
      "difference: median over the sequences of this method's error less that of the best of ours. "
      "●: the interval excludes 0; ○: it holds 0, so the difference is open. A sequence without an "
      "estimate counts as wrong mode. \"new\" marks what the paper does not have.",
      "dense");
}

std::string ComparedSentence(const EvaluationResults& results) {
  int compared = 0;
  int beaten = 0;
  int beaten_rate = 0;
  std::vector<std::string> ahead;
  for (size_t i = 0; i < results.accuracy.size(); ++i) {
    if (results.methods[i].is_histogram) continue;
    const MethodAccuracy& accuracy = results.accuracy[i];
    ++compared;
    if (accuracy.median_difference_deg.low > 0.0) ++beaten;
    if (accuracy.difference_of_wrong_mode_rates.low > 0.0) ++beaten_rate;
    if (accuracy.median_difference_deg.high < 0.0 ||
        accuracy.difference_of_wrong_mode_rates.high < 0.0) {
      ahead.push_back(MethodName(results.methods[i]));
    }
  }
  if (compared == 0) return "";
  std::string text = Format(
      " Of %d compared methods, %d have a larger error and %d a larger wrong-mode rate with an "
      "interval that excludes 0; ",
      compared,
      beaten,
      beaten_rate);
  return text + (ahead.empty() ? "none is ahead of it in either."
                               : "ahead of it in one or both: " + ListText(ahead) + ".");
}

// Over the sequences of an object.
double MedianOf(const SequenceErrors& object, size_t method) {
  const std::vector<double> errors = WithMissing(object.final_deg[method]);
  return errors.empty() ? std::numeric_limits<double>::quiet_NaN() : Median(errors);
}

std::string SequencesSentence(const EvaluationResults& results) {
  const std::optional<size_t> best = BestOurs(results);
  if (!best) return "";
  const SequenceErrors* hardest = nullptr;
  int first = 0;
  for (const SequenceErrors& object : results.sequences) {
    const double ours = MedianOf(object, *best);
    if (!std::isfinite(ours)) continue;
    if (hardest == nullptr || ours > MedianOf(*hardest, *best)) hardest = &object;
    bool least = true;
    for (size_t i = 0; i < results.methods.size(); ++i) {
      least = least && (results.methods[i].is_histogram || !(MedianOf(object, i) < ours));
    }
    if (least) ++first;
  }
  if (hardest == nullptr) return "";
  return Format(
             "%s has no larger median than any compared method on %d of %zu objects; hardest for "
             "it "
             "is ",
             MethodName(results.methods[*best]).c_str(),
             first,
             results.sequences.size()) +
         hardest->model_id + Format(" with %.3f°.", MedianOf(*hardest, *best));
}

std::string SequenceRow(const EvaluationResults& results, const SequenceErrors& object) {
  std::vector<double> medians;
  for (size_t i = 0; i < results.methods.size(); ++i) medians.push_back(MedianOf(object, i));
  const std::vector<double> finite = Finite(medians);
  const double least = finite.empty() ? 0.0 : *std::min_element(finite.begin(), finite.end());
  const std::vector<double> detections = Finite(object.detection_deg);
  std::string row = "<tr><td title=\"" + EscapeHtml(object.symmetry) + "\">" +
                    EscapeHtml(object.model_id) + "</td>";
  row += HtmlCell(object.num_views == 0 ? "–"
                                        : Format("%.0f",
                                                 100.0 * static_cast<double>(object.num_found) /
                                                     static_cast<double>(object.num_views)));
  row += HtmlCell(detections.empty() ? "–" : CompactText(Median(detections)));
  for (const double median : medians) {
    row += HtmlCell(CompactText(median),
                    median == least                   ? "first"
                    : median > results.wrong_mode_deg ? "far"
                                                      : "");
  }
  return row + "</tr>";
}

}  // namespace

std::string RunSection(const EvaluationResults& results) {
  const size_t sequences = NumSequences(results);
  std::string list = "<dl>";
  list += Entry("command", "<code>" + EscapeHtml(results.command) + "</code>");
  list += Entry("version", EscapeHtml(results.version));
  list += Entry("seed", std::to_string(results.seed));
  list += Entry("data",
                Format("%zu sequences of %d views over %zu objects; %zu objects on the circle of "
                       "views; %zu methods",
                       sequences,
                       results.views_per_sequence,
                       results.sequences.size(),
                       results.circle.size(),
                       results.methods.size()));
  list += Entry("histogram", Format("k = %d", results.histogram_k));
  list +=
      Entry("error",
            "angle of the rotation between estimate and truth; <i>modulo symmetry</i>: the least "
            "over the object's symmetry group (an angle about a free axis counts nothing); "
            "<i>plain</i>: as the paper has it");
  list += Entry("wrong mode",
                Format("a final orientation %g° or more from the truth, modulo symmetry",
                       results.wrong_mode_deg));
  return list + "</dl>";
}

std::string SummarySection(const EvaluationResults& results, const ReportFigures& figures) {
  if (results.accuracy.empty()) {
    return Section(
        "summary", "Summary", "No sequences were run, so no method is compared here.", "");
  }
  std::string sentence;
  if (const std::optional<size_t> best = BestOurs(results)) {
    const MethodAccuracy& accuracy = results.accuracy[*best];
    sentence = Format("%s is the best of our variants: median error ",
                      MethodName(results.methods[*best]).c_str()) +
               IntervalText(accuracy.median_deg, 1, 3, "°") +
               " modulo symmetry, in the wrong mode in " +
               IntervalText(accuracy.wrong_mode_rate, 100, 1, " %") +
               Format(" of %zu sequences.", NumSequences(results)) + ComparedSentence(results);
  }
  return Section("summary",
                 "Summary",
                 sentence,
                 FigureCard(figures,
                            "forest",
                            "median error and wrong-mode rate of every method",
                            "Points with 95 % intervals; ours in blue, the best of ours shaded. "
                            "Differences are to the best of ours: a filled point's interval "
                            "excludes 0, a hollow one's doesn't; right of the line is worse. The "
                            "axis of the median error is logarithmic, the other three are linear "
                            "near 0 and logarithmic far from it. *: not in the paper.") +
                     AccuracyTable(results));
}

std::string SequencesSection(const EvaluationResults& results) {
  if (results.sequences.empty()) {
    return Section("sequences", "Sequences by object", "No sequences were run.", "");
  }
  std::string rows = "<tr>" + HeadCell("object") + HeadCell("found (%)") + HeadCell("detection");
  for (const MethodInfo& method : results.methods) {
    rows += HeadCell(MethodName(method), method.is_histogram ? "ours" : "");
  }
  rows += "</tr>";
  for (const SequenceErrors& object : results.sequences) rows += SequenceRow(results, object);
  return Section(
      "sequences",
      "Sequences by object: median final error",
      SequencesSentence(results),
      TableCard(
          rows,
          Format("Degrees, modulo symmetry, median over the sequences; the least of a row is "
                 "bold, medians beyond %g° are red. Found: views with a detection. Detection: "
                 "median over all of those. A sequence without an estimate counts as %g°.",
                 results.wrong_mode_deg,
                 kMissingErrorDeg),
          "dense"));
}

std::string TimeSection(const EvaluationResults& results, const ReportFigures& figures) {
  size_t fastest = results.accuracy.size();
  for (size_t i = 0; i < results.accuracy.size(); ++i) {
    const double seconds = results.accuracy[i].seconds_per_view;
    if (!std::isfinite(seconds)) continue;
    if (fastest == results.accuracy.size() ||
        seconds < results.accuracy[fastest].seconds_per_view) {
      fastest = i;
    }
  }
  if (fastest == results.accuracy.size()) {
    return Section("time", "Time per view", "No times were taken.", "");
  }
  std::string sentence = "Fastest is " + MethodName(results.methods[fastest]) +
                         Format(" with %.3g ms", 1e3 * results.accuracy[fastest].seconds_per_view);
  if (const std::optional<size_t> best = BestOurs(results); best && *best != fastest) {
    sentence += "; the best of ours, " + MethodName(results.methods[*best]) +
                Format(", takes %.3g ms", 1e3 * results.accuracy[*best].seconds_per_view);
  }
  return Section(
      "time",
      "Time per view",
      sentence + ".",
      FigureCard(figures,
                 "time",
                 "computing time of every method",
                 "Median computing time per view, on one core. Logarithmic. *: not in the paper."));
}

}  // namespace vantage
