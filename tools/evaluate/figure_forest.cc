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

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Differences are drawn at asinh(difference / this): linear near 0, logarithmic far from it.
constexpr double kLinearWithinDeg = 0.02;

double Stretch(double difference_deg) { return std::asinh(difference_deg / kLinearWithinDeg); }

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
    plot += block + " using 1:4:2:3:5 with xerrorbars pt 0 lw 2 lc rgb variable, " + block +
            " using 1:4:5 with points pt 7 ps 0.9 lc rgb variable";
    // A hollow point is a filled one with a white middle.
    if (i == 1) plot += ", " + block + " using 1:4 with points pt 7 ps 0.5 lc rgb '#ffffff'";
  }
  return plot.empty() ? script : script + plot + "\n";
}

std::string DifferenceAxis(const Range& range) {
  std::vector<double> tics;
  const double low = std::min(range.low, Stretch(-0.03));
  const double high = std::max(range.high, Stretch(0.3));
  for (const double tic : {-100.0, -10.0, -1.0, -0.1, 0.0, 0.1, 1.0, 10.0, 100.0}) {
    if (Stretch(tic) >= low && Stretch(tic) <= high) tics.push_back(tic);
  }
  std::string text =
      Format("unset logscale x\nset xrange [%g:%g]\nset xtics (", low - 0.4, high + 0.4);
  const bool crowded = tics.size() > 6;
  for (size_t i = 0; i < tics.size(); ++i) {
    const bool labeled =
        !crowded || tics[i] == 0.0 || std::abs(tics[i]) == 1.0 || std::abs(tics[i]) == 100.0;
    text += Format("%s'%s' %g",
                   i == 0 ? "" : ", ",
                   labeled ? Format("%g", tics[i]).c_str() : "",
                   Stretch(tics[i]));
  }
  return text + ")\n";
}

std::string LinearAxis(const Range& range, double least) {
  const double low = std::min(range.low, 0.0);
  const double high = std::max({range.high, 0.0, low + least});
  const double margin = 0.04 * (high - low);
  const double step = high - low > 60 ? 25 : high - low > 25 ? 10 : high - low > 10 ? 5 : 2;
  return Format(
      "unset logscale x\nset xtics %g\nset xrange [%g:%g]\n", step, low - margin, high + margin);
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
    const bool best = results.methods[i].id == results.best_ours;
    const Interval& median = accuracy.median_deg;
    medians.Add({DrawnError(median.value), DrawnError(median.low), DrawnError(median.high)}, true);
    const Interval& rate = accuracy.wrong_mode_rate;
    rates.Add({100 * rate.value, 100 * rate.low, 100 * rate.high}, true);
    Interval paired = accuracy.median_difference_deg;
    Interval rate_difference = accuracy.difference_of_wrong_mode_rates;
    if (best) paired = rate_difference = {NAN, NAN, NAN};  // To itself.
    differences.Add({Stretch(paired.value), Stretch(paired.low), Stretch(paired.high)},
                    ExcludesZero(paired));
    rate_differences.Add(
        {100 * rate_difference.value, 100 * rate_difference.low, 100 * rate_difference.high},
        ExcludesZero(rate_difference));
  }
  const int height = 110 + 27 * static_cast<int>(results.methods.size());
  const double bottom = 62.0 / height;
  const double top = 1.0 - 38.0 / height;
  std::string script = FigureHead(1120, height) + "set multiplot\nset border 1 lc rgb '#888888'\n";
  script += PlacePanel({0.205, 0.405, bottom, top}) + MethodRows(results, true) +
            "set title 'median error'\nset xlabel 'degrees'\n" +
            LogarithmicRange('x', medians.range.low, medians.range.high) +
            PlotColumn(results, medians, "medians");
  script += PlacePanel({0.42, 0.62, bottom, top}) + MethodRows(results, false) + kZeroLine +
            "set title 'its difference to the best of ours'\nset xlabel 'degrees, paired'\n" +
            DifferenceAxis(differences.range) + PlotColumn(results, differences, "differences");
  script += PlacePanel({0.645, 0.805, bottom, top}) + MethodRows(results, false) +
            "unset arrow\nset title 'wrong-mode rate'\nset xlabel 'percent'\n" +
            LinearAxis(rates.range, 5) + PlotColumn(results, rates, "rates");
  script += PlacePanel({0.83, 0.985, bottom, top}) + MethodRows(results, false) + kZeroLine +
            "set title 'its difference'\nset xlabel 'percentage points'\n" +
            LinearAxis(rate_differences.range, 5) +
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
  const int height = 70 + 25 * static_cast<int>(results.methods.size());
  const double left = std::pow(10.0, std::floor(std::log10(range.low) - 0.05));
  std::string script =
      FigureHead(1120, height) + "set border 1 lc rgb '#888888'\n$data << END\n" + data + "END\n";
  script += PlacePanel({0.205, 0.97, 58.0 / height, 1.0 - 10.0 / height}) +
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
