#include "tools/evaluate/figure_forest.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "common/format.h"
#include "tools/evaluate/figure_style.h"
#include "tools/evaluate/report_numbers.h"
#include "tools/support/gnuplot.h"

namespace vantage {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Values are drawn at asinh(value / this): linear near 0, logarithmic far from it.
constexpr double kLinearWithinDeg = 0.02;
constexpr double kLinearWithinPercent = 0.5;

Interval Stretched(const Interval& interval, double factor) {
  return {std::asinh(factor * interval.value),
          std::asinh(factor * interval.low),
          std::asinh(factor * interval.high)};
}

struct Range {
  double low = kInfinity;
  double high = -kInfinity;
  void Extend(double value) {
    if (!std::isfinite(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
};

// One interval a method, as they are drawn.
struct Column {
  std::vector<Interval> intervals;
  std::vector<bool> filled;
  Range range;

  void Add(const Interval& interval, bool is_filled) {
    intervals.push_back(interval);
    filled.push_back(is_filled);
    for (const double value : {interval.value, interval.low, interval.high}) range.Extend(value);
  }
};

// Lines for the intervals, then the points: filled ones, hollow ones.
std::string PlotColumn(const EvaluationResults& results,
                       const Column& column,
                       const std::string& name) {
  std::array<std::string, 2> points;
  for (size_t i = 0; i < column.intervals.size(); ++i) {
    const Interval& interval = column.intervals[i];
    points[column.filled[i] ? 0 : 1] += Format("%s %s %s %g 0x%s\n",
                                               DataNumber(interval.value).c_str(),
                                               DataNumber(interval.low).c_str(),
                                               DataNumber(interval.high).c_str(),
                                               RowOfMethod(results, i),
                                               MethodColor(results.methods[i]) + 1);
  }
  std::string script;
  std::string plot;
  for (size_t i = 0; i < points.size(); ++i) {
    if (points[i].empty()) continue;
    const std::string block = Format("$%s%zu", name.c_str(), i);
    script += block + " << END\n" + points[i] + "END\n";
    plot += plot.empty() ? "plot " : ", ";
    plot += block + " using 1:4:2:3:5 with xerrorbars pt 0 lw 2.4 lc rgb variable, " + block +
            " using 1:4:5 with points pt 7 ps 0.75 lc rgb variable";
    // A hollow point is a filled one with a white middle.
    if (i == 1) plot += ", " + block + " using 1:4 with points pt 7 ps 0.4 lc rgb '#ffffff'";
  }
  return plot.empty() ? script : script + plot + "\n";
}

// The axis of values that were stretched by `scale`.
std::string StretchedAxis(const Range& range, double scale, double least_low, double least_high) {
  const auto place = [scale](double value) { return std::asinh(value / scale); };
  const double low = std::min(range.low, place(least_low));
  const double high = std::max(range.high, place(least_high));
  std::vector<double> tics;
  for (const double tic : {-100.0, -10.0, -1.0, -0.1, 0.1, 1.0, 10.0, 100.0}) {
    if (place(tic) >= low && place(tic) <= high) tics.push_back(tic);
  }
  const bool crowded = tics.size() > 5;
  std::string text =
      Format("unset logscale x\nset xrange [%g:%g]\nset xtics ('0' 0", low - 0.3, high + 0.3);
  for (const double tic : tics) {
    if (std::abs(tic) < 2.0 * scale) continue;  // Too near to 0.
    const bool labeled = !crowded || std::abs(tic) == 1.0 || std::abs(tic) == 100.0;
    text += Format(", '%s' %g", labeled ? Format("%g", tic).c_str() : "", place(tic));
  }
  return text + ")\n";
}

constexpr const char* kZeroLine =
    "set arrow 1 from first 0, graph 0 to first 0, graph 1 nohead lc rgb '#888888' lw 1 back\n";

}  // namespace

Result<std::string> ForestFigure(const EvaluationResults& results) {
  if (results.accuracy.empty()) return std::string();
  Column medians;
  Column differences;
  Column rates;
  Column rate_differences;
  for (size_t i = 0; i < results.accuracy.size(); ++i) {
    const MethodAccuracy& accuracy = results.accuracy[i];
    const Interval& median = accuracy.median_deg;
    medians.Add({DrawnError(median.value), DrawnError(median.low), DrawnError(median.high)}, true);
    rates.Add(Stretched(accuracy.wrong_mode_rate, 100.0 / kLinearWithinPercent), true);
    Interval paired = accuracy.median_difference_deg;
    Interval rate = accuracy.difference_of_wrong_mode_rates;
    if (results.methods[i].id == results.best_ours) paired = rate = {kNone, kNone, kNone};
    differences.Add(Stretched(paired, 1.0 / kLinearWithinDeg), ExcludesZero(paired));
    rate_differences.Add(Stretched(rate, 100.0 / kLinearWithinPercent), ExcludesZero(rate));
  }
  if (!std::isfinite(medians.range.low)) medians.range = {0.1, 10.0};  // All are NaN.
  const int height = 110 + 27 * static_cast<int>(results.methods.size());
  const double bottom = 62.0 / height;
  const double top = 1.0 - 38.0 / height;
  std::string script =
      FigureHead(1120, height) + "set multiplot\nset errorbars 0\nset border 1 lc rgb '#888888'\n";
  script += PlacePanel({0.205, 0.405, bottom, top}) + MethodRows(results, true) +
            "set title 'median error'\nset xlabel 'degrees'\n" +
            LogarithmicRange('x', medians.range.low, medians.range.high) +
            PlotColumn(results, medians, "medians");
  script += PlacePanel({0.42, 0.62, bottom, top}) + MethodRows(results, false) + kZeroLine +
            "set title 'its difference to the best of ours'\nset xlabel 'degrees, paired'\n" +
            StretchedAxis(differences.range, kLinearWithinDeg, -0.03, 0.3) +
            PlotColumn(results, differences, "differences");
  script += PlacePanel({0.645, 0.805, bottom, top}) + MethodRows(results, false) +
            "unset arrow\nset title 'wrong-mode rate'\nset xlabel 'percent'\n" +
            StretchedAxis(rates.range, kLinearWithinPercent, 0.0, 12.0) +
            PlotColumn(results, rates, "rates");
  script += PlacePanel({0.83, 0.985, bottom, top}) + MethodRows(results, false) + kZeroLine +
            "set title 'its difference'\nset xlabel 'percentage points'\n" +
            StretchedAxis(rate_differences.range, kLinearWithinPercent, -1.1, 1.1) +
            PlotColumn(results, rate_differences, "rate_differences");
  return RunGnuplot(script + "unset multiplot\n");
}

Result<std::string> TimeFigure(const EvaluationResults& results) {
  Range range;
  std::string data;
  for (size_t i = 0; i < results.accuracy.size(); ++i) {
    const double milliseconds = std::max(1e3 * results.accuracy[i].seconds_per_view, 1e-6);
    range.Extend(milliseconds);
    data += Format("%s %g 0x%s\n",
                   DataNumber(milliseconds).c_str(),
                   RowOfMethod(results, i),
                   MethodColor(results.methods[i]) + 1);
  }
  if (!std::isfinite(range.low)) return std::string();
  const int height = 90 + 25 * static_cast<int>(results.methods.size());
  const double left = std::pow(10.0, std::floor(std::log10(range.low) - 0.05));
  std::string script =
      FigureHead(1120, height) + "set border 1 lc rgb '#888888'\n$data << END\n" + data + "END\n";
  script += PlacePanel({0.205, 0.97, 78.0 / height, 1.0 - 10.0 / height}) +
            MethodRows(results, true) + LogarithmicRange('x', left, range.high);
  script += Format(
      "set xlabel 'milliseconds per view, one core'\n"
      "plot $data using (%g):2:($1-%g):(0):3 with vectors nohead lw 2 lc rgb variable, "
      "$data using 1:2:3 with points pt 7 ps 1 lc rgb variable\n",
      left,
      left);
  return RunGnuplot(script);
}

}  // namespace vantage
