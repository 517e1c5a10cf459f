#include "tools/evaluate/confusion_figures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "common/format.h"
#include "tools/evaluate/figure_style.h"
#include "tools/support/gnuplot.h"

namespace vantage {
namespace {

// By strategy, told apart with impaired color vision; ours is the first.
constexpr std::array<const char*, 5> kColors = {
    kOursColor, "#e69f00", "#009e73", "#a0528c", kOtherColor};
constexpr std::array<int, 5> kPoints = {7, 5, 9, 13, 6};

const char* ColorOf(size_t strategy) { return kColors[strategy % kColors.size()]; }

std::string Key(int maxcols) {
  return Format("set key outside bottom center horizontal maxcols %d samplen 2.5\n", maxcols);
}

// Rows are objects, the last one all of them.
std::string NeededScript(const ConfusionResults& results) {
  const size_t num_rows = results.objects.size() + 1;
  const int height = 130 + 34 * static_cast<int>(num_rows);
  std::string script = FigureHead(1120, height) + "set border 1 lc rgb '#888888'\n" + Key(5) +
                       "set lmargin 16\nset grid xtics noytics\nunset ytics\n";
  script += Format(
      "set xlabel 'views until the right mode holds, mean and 95 %% interval'\n"
      "set xrange [0:%d]\nset yrange [0.4:%zu.6]\n",
      results.views + 1,
      num_rows);
  const auto y_of = [&](size_t row) { return static_cast<double>(num_rows - row); };
  for (size_t row = 0; row < num_rows; ++row) {
    const bool is_all = row == results.objects.size();
    const std::string name = is_all ? "all objects" : results.objects[row].model_id;
    script += "set label " + FigureText(name, 20) +
              Format(" at graph -0.01, first %g right textcolor rgb '%s'\n", y_of(row), kInkColor);
    if (is_all) {
      script += Format(
          "set object rectangle from graph 0, first %g to graph 1, first %g behind "
          "fc rgb '#eef1f4' fs solid noborder\n",
          y_of(row) - 0.5,
          y_of(row) + 0.5);
    }
  }
  std::string plot;
  for (size_t s = 0; s < results.strategies.size(); ++s) {
    script += Format("$needed%zu << END\n", s);
    for (size_t row = 0; row < num_rows; ++row) {
      const ViewsNeeded& needed = row < results.objects.size() ? results.objects[row].strategies[s]
                                                               : results.all_objects[s];
      const double offset = 0.3 - 0.15 * static_cast<double>(s);
      script += Format("%s %g %s %s\n",
                       DataNumber(needed.mean.value).c_str(),
                       y_of(row) + offset,
                       DataNumber(needed.mean.low).c_str(),
                       DataNumber(needed.mean.high).c_str());
    }
    script += "END\n";
    plot +=
        (plot.empty() ? "plot " : ", ") +
        Format("$needed%zu using 1:2:3:4 with xerrorbars pt %d ps 0.9 lw 1.8 lc rgb '%s' title ",
               s,
               kPoints[s % kPoints.size()],
               ColorOf(s)) +
        FigureText(results.strategies[s], 30);
  }
  return script + plot + "\n";
}

std::string OpenScript(const ConfusionResults& results) {
  std::string script = FigureHead(760, 420) + Key(3);
  script += Format(
      "set xlabel 'views'\nset ylabel 'right mode not held (%% of the sequences)'\n"
      "set xrange [0:%d]\nset yrange [0:100]\nset xtics 1\n",
      results.views);
  std::string plot;
  const auto width = static_cast<size_t>(results.views) + 1;
  for (size_t s = 0; s < results.strategies.size(); ++s) {
    script += Format("$open%zu << END\n", s);
    for (size_t n = 0; n < width; ++n) {
      script += Format("%zu %g\n", n, 100.0 * results.still_open[s * width + n]);
    }
    script += "END\n";
    plot += (plot.empty() ? "plot " : ", ") +
            Format("$open%zu using 1:2 with linespoints pt %d ps 0.6 lw %g lc rgb '%s' title ",
                   s,
                   kPoints[s % kPoints.size()],
                   s == 0 ? 3.2 : 2.0,
                   ColorOf(s)) +
            FigureText(results.strategies[s], 30);
  }
  return script + plot + "\n";
}

std::string CalibrationScript(const ConfusionResults& results) {
  std::string script = FigureHead(420, 420) +
                       "set size square\nset xrange [0:1]\nset yrange [0:1]\n"
                       "set xlabel 'probability of the best hypothesis'\n"
                       "set ylabel 'share that is right'\n$bins << END\n";
  for (const CalibrationBin& bin : results.calibration) {
    if (bin.count > 0) script += Format("%g %g\n", bin.mean_mass, bin.right);
  }
  script += Format(
      "END\nplot x with lines dt 2 lw 1.5 lc rgb '%s', "
      "$bins using 1:2 with linespoints pt 7 ps 0.9 lw 2.4 lc rgb '%s'\n",
      kOtherColor,
      kOursColor);
  return script;
}

// The objects of Fig. 18, each once, in their order.
std::vector<std::string> StepObjects(const ConfusionResults& results) {
  std::vector<std::string> ids;
  for (const StepQuartiles& line : results.steps) {
    if (std::find(ids.begin(), ids.end(), line.model_id) == ids.end()) ids.push_back(line.model_id);
  }
  return ids;
}

std::string StepPanel(const StepQuartiles& line, size_t panel) {
  std::string script = Format("$steps%zu << END\n", panel);
  for (size_t view = 0; view < line.final_median.size(); ++view) {
    script += Format("%zu", view + 1);
    for (const auto* errors :
         {&line.detection_median, &line.final_low, &line.final_median, &line.final_high}) {
      script += ' ';
      script += DataNumber(DrawnError((*errors)[view]));
    }
    script += "\n";
  }
  return script + Format(
                      "END\nplot $steps%zu using 1:3:5 with filledcurves fc rgb '#cfe0f2' , "
                      "$steps%zu using 1:2 with points pt 3 ps 0.5 lw 1.3 lc rgb '%s', "
                      "$steps%zu using 1:4 with lines lw 2.8 lc rgb '%s'\n",
                      panel,
                      panel,
                      kDetectionColor,
                      panel,
                      kOursColor);
}

std::string StepsScript(const ConfusionResults& results) {
  const std::vector<std::string> objects = StepObjects(results);
  const size_t columns = results.strategies.size();
  const int height = 90 + 220 * static_cast<int>(objects.size());
  double low = 1.0;
  double high = 10.0;
  for (const StepQuartiles& line : results.steps) {
    for (const auto* errors : {&line.detection_median, &line.final_low, &line.final_high}) {
      for (const double error : *errors) {
        low = std::min(low, DrawnError(error));
        high = std::max(high, DrawnError(error));
      }
    }
  }
  std::string script = FigureHead(1120, height, 13) + "set multiplot\n" +
                       LogarithmicRange('y', low, high) +
                       Format("set xrange [0.5:%d.5]\nset xtics 5\n", results.views);
  for (size_t i = 0; i < results.steps.size(); ++i) {
    const size_t row = i / columns;
    const size_t column = i % columns;
    const double left = 0.075 + 0.92 * static_cast<double>(column) / static_cast<double>(columns);
    const double top = 1.0 - (30.0 + 220.0 * static_cast<double>(row)) / height;
    script += PlacePanel(
        {left, left + 0.92 / static_cast<double>(columns) - 0.012, top - 165.0 / height, top});
    script += column == 0 ? "set ylabel " + FigureText(results.steps[i].model_id + ": error (°)") +
                                "\nset format y '%g'\n"
                          : "unset ylabel\nset format y ''\n";
    script += row + 1 == objects.size() ? "set xlabel 'views'\n" : "unset xlabel\n";
    script += row == 0 ? "set title " + FigureText(results.steps[i].strategy) + " offset 0,-0.5\n"
                       : "unset title\n";
    script += StepPanel(results.steps[i], i);
  }
  return script + "unset multiplot\n";
}

}  // namespace

Result<ReportFigures> DrawConfusionFigures(const ConfusionResults& results) {
  std::vector<std::pair<const char*, std::string>> scripts;
  if (!results.objects.empty()) {
    scripts.emplace_back("needed", NeededScript(results));
    scripts.emplace_back("open", OpenScript(results));
    scripts.emplace_back("calibration", CalibrationScript(results));
  }
  if (!results.steps.empty()) scripts.emplace_back("steps", StepsScript(results));
  ReportFigures figures;
  for (const auto& [name, script] : scripts) {
    Result<std::string> figure = RunGnuplot(script);
    if (!figure) return figure.error();
    figures[name] = std::move(*figure);
  }
  return figures;
}

}  // namespace vantage
