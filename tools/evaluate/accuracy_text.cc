#include "tools/evaluate/accuracy_text.h"

#include "common/format.h"

namespace vantage {
namespace {

std::string IntervalText(const Interval& interval, double unit, int digits) {
  return Format("%.*f (%.*f..%.*f)",
                digits,
                unit * interval.value,
                digits,
                unit * interval.low,
                digits,
                unit * interval.high);
}

std::string Row(const MethodInfo& method, const MethodAccuracy& accuracy) {
  return Format("%-26s %-26s %-22s %-22s %-28s %.0f\n",
                method.label.c_str(),
                IntervalText(accuracy.median_deg, 1.0, 4).c_str(),
                IntervalText(accuracy.wrong_mode_rate, 100.0, 2).c_str(),
                IntervalText(accuracy.early_wrong_mode_rate, 100.0, 2).c_str(),
                IntervalText(accuracy.difference_of_medians_deg, 1.0, 4).c_str(),
                1e6 * accuracy.seconds_per_view);
}

}  // namespace

std::string AccuracyText(const EvaluationResults& results) {
  if (results.accuracy.empty()) return "";
  size_t num_sequences = 0;
  for (const SequenceErrors& model : results.sequences) {
    num_sequences += model.final_deg.front().size();
  }
  std::string text =
      Format("%zu sequences of %d views, %zu objects; errors modulo symmetry, 95 %% intervals\n",
             num_sequences,
             results.views_per_sequence,
             results.sequences.size());
  text += Format("%-26s %-26s %-22s %-22s %-28s %s\n",
                 "method",
                 "median (deg)",
                 "wrong mode (%)",
                 Format("after %d views (%%)", results.early_views).c_str(),
                 "median less the best's (deg)",
                 "us a view");
  for (size_t m = 0; m < results.accuracy.size(); ++m) {
    text += Row(results.methods[m], results.accuracy[m]);
  }
  text +=
      Format("not told the symmetry: median less that of %s (deg)\n", results.best_blind.c_str());
  for (size_t m = 0; m < results.accuracy.size(); ++m) {
    if (results.methods[m].is_histogram) continue;
    text += Format("%-26s %s\n",
                   results.methods[m].label.c_str(),
                   IntervalText(results.accuracy[m].difference_to_blind_deg, 1.0, 4).c_str());
  }
  return text;
}

}  // namespace vantage
