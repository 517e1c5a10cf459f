#include "tools/evaluate/report_numbers.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/format.h"

namespace vantage {

std::vector<double> Finite(std::span<const double> values) {
  std::vector<double> finite;
  for (const double value : values) {
    if (std::isfinite(value)) finite.push_back(value);
  }
  return finite;
}

std::vector<double> WithMissing(std::span<const double> values) {
  std::vector<double> all;
  for (const double value : values) {
    all.push_back(std::isfinite(value) ? value : kMissingErrorDeg);
  }
  return all;
}

double FinalError(std::span<const double> by_view) {
  return by_view.empty() ? std::numeric_limits<double>::quiet_NaN() : by_view.back();
}

std::optional<size_t> FindMethod(const EvaluationResults& results, const std::string& id) {
  for (size_t i = 0; i < results.methods.size(); ++i) {
    if (results.methods[i].id == id) return i;
  }
  return std::nullopt;
}

std::optional<size_t> BestOurs(const EvaluationResults& results) {
  return FindMethod(results, results.best_ours);
}

std::vector<double> CircleFinals(const EvaluationResults& results, size_t method, bool symmetric) {
  std::vector<double> finals;
  for (const CircleErrors& object : results.circle) {
    finals.push_back(FinalError((symmetric ? object.step_symmetric_deg : object.step_deg)[method]));
  }
  return finals;
}

BoxSummary SummarizeBox(std::span<const double> values) {
  BoxSummary box;
  box.lower_quartile = Quantile(values, 0.25);
  box.median = Median(values);
  box.upper_quartile = Quantile(values, 0.75);
  const double reach = 1.5 * (box.upper_quartile - box.lower_quartile);
  box.lower_whisker = box.lower_quartile;
  box.upper_whisker = box.upper_quartile;
  for (const double value : values) {
    if (value < box.lower_quartile - reach || value > box.upper_quartile + reach) {
      box.outliers.push_back(value);
      continue;
    }
    box.lower_whisker = std::min(box.lower_whisker, value);
    box.upper_whisker = std::max(box.upper_whisker, value);
  }
  return box;
}

bool ExcludesZero(const Interval& interval) { return interval.low > 0.0 || interval.high < 0.0; }

std::string NumberText(double value, int decimals) {
  return std::isfinite(value) ? Format("%.*f", decimals, value) : "–";
}

std::string CompactText(double value) {
  return NumberText(value, value < 9.9995 ? 3 : value < 99.995 ? 2 : 1);
}

std::string ListText(const std::vector<std::string>& names) {
  std::string text;
  for (size_t i = 0; i < names.size(); ++i) {
    if (i > 0) text += i + 1 == names.size() ? " and " : ", ";
    text += names[i];
  }
  return text;
}

std::string MethodName(const MethodInfo& method) {
  return method.label.empty() ? method.id : method.label;
}

}  // namespace vantage
