#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tools/evaluate/evaluation_results.h"

namespace vantage {

/// What an orientation that is not there counts as where errors are put in order, deg: the largest
/// error that there is.
inline constexpr double kMissingErrorDeg = 180.0;

/// Without NaN.
std::vector<double> Finite(std::span<const double> values);
/// With kMissingErrorDeg for NaN.
std::vector<double> WithMissing(std::span<const double> values);
/// The error after the last view; NaN without views.
double FinalError(std::span<const double> by_view);

/// Place of a method in EvaluationResults::methods.
std::optional<size_t> FindMethod(const EvaluationResults& results, const std::string& id);
std::optional<size_t> BestOurs(const EvaluationResults& results);

/// Final errors of a method on the circle, by object.
std::vector<double> CircleFinals(const EvaluationResults& results, size_t method, bool symmetric);

/// The box of a box plot (Tukey): quartiles, the outermost values within 1.5 interquartile
/// distances of them, and the values beyond.
struct BoxSummary {
  double lower_whisker = 0.0;
  double lower_quartile = 0.0;
  double median = 0.0;
  double upper_quartile = 0.0;
  double upper_whisker = 0.0;
  std::vector<double> outliers;
};
/// @param values none NaN, at least one.
BoxSummary SummarizeBox(std::span<const double> values);

/// Whether the interval lies on one side of 0.
bool ExcludesZero(const Interval& interval);

/// Three decimals as the paper has, a dash for NaN.
std::string NumberText(double value, int decimals = 3);
/// Four digits at most, three decimals at most, for tables of many columns.
std::string CompactText(double value);
/// "duck, gear and mug".
std::string ListText(const std::vector<std::string>& names);
/// The label, or the id where it has none.
std::string MethodName(const MethodInfo& method);

}  // namespace vantage
