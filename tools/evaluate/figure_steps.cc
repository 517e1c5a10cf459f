#include "tools/evaluate/figure_steps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "common/format.h"
#include "tools/evaluate/figure_style.h"
#include "tools/evaluate/paper_figures.h"
#include "tools/evaluate/report_numbers.h"
#include "tools/support/gnuplot.h"

namespace vantage {
namespace {

constexpr size_t kStepObjects = 3;
constexpr size_t kKeyLength = 26;  // characters of a method in a key
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

struct Line {
  const char* method_id;
  const char* style;
};
// What Fig. 10 compares ours with, told apart by hue and by dashes.
constexpr std::array<Line, 4> kComparedLines = {
    Line{kKnnId, "lw 2.2 lc rgb '#009e73'"},
    {kParticleFilterId, "lw 2.6 lc rgb '#e69f00'"},
    {kBinghamProductId, "lw 2.2 dt 2 lc rgb '#a0528c'"},
    {kBinghamParticlesId, "lw 2.4 dt 3 lc rgb '#50555c'"}};

// The plot of one panel: data blocks and the parts of a plot command, in drawing order.
class Panel {
 public:
  explicit Panel(size_t index) : index_(index) {}

  /// @param title quoted, or empty for none.
  void Add(const std::vector<double>& errors_deg,
           const std::string& with,
           const std::string& title) {
    if (!title.empty()) {
      key_ += (key_.empty() ? "keyentry with " : ", keyentry with ") + with + " title " + title;
    }
    if (Finite(errors_deg).empty()) return;
    const std::string block = Format("$errors%zu_%zu", index_, count_++);
    data_ += block + " << END\n";
    for (size_t view = 0; view < errors_deg.size(); ++view) {
      data_ += Format("%zu %s\n", view + 1, DataNumber(DrawnError(errors_deg[view])).c_str());
    }
    data_ += "END\n";
    plot_ += (plot_.empty() ? "plot " : ", ") + block + " using 1:2 with " + with + " notitle";
  }
  /// An empty panel still has its axes.
  [[nodiscard]] std::string Script() const {
    return data_ + (plot_.empty() ? "plot NaN notitle\n" : plot_ + "\n");
  }
  /// Script of a key at the bottom of the figure, as wide as it.
  [[nodiscard]] std::string Key(int height, int rows) const {
    return PlacePanel({0.07, 0.98, 0.0, (14.0 + 20.0 * rows) / height}) +
           Format(
               "unset border\nunset tics\nunset xlabel\nunset ylabel\nunset title\n"
               "unset logscale\nset xrange [0:1]\nset yrange [0:1]\n"
               "set key center center vertical maxrows %d Left reverse samplen 2.5 width -3\n"
               "plot NaN notitle, %s\n",
               rows,
               key_.c_str());
  }

 private:
  size_t index_;
  size_t count_ = 0;
  std::string data_;
  std::string plot_;
  std::string key_;
};

void Extend(const std::vector<double>& errors_deg, double* low, double* high) {
  for (const double error : errors_deg) {
    if (std::isnan(error)) continue;
    *low = std::min(*low, DrawnError(error));
    *high = std::max(*high, DrawnError(error));
  }
}

// One range for all panels, so that they compare.
std::string ErrorRange(const std::vector<const std::vector<double>*>& lines) {
  double low = 1.0;
  double high = 10.0;
  for (const std::vector<double>* line : lines) Extend(*line, &low, &high);
  return LogarithmicRange('y', low, high);
}

std::string ViewAxis(size_t views) {
  return Format("set xrange [0.3:%g]\nset xtics %d\n",
                static_cast<double>(views) + 0.7,
                views > 16  ? 5
                : views > 8 ? 2
                            : 1);
}

size_t MostViews(const EvaluationResults& results) {
  size_t views = 1;
  for (const CircleErrors& object : results.circle) {
    views = std::max(views, object.detection_deg.size());
  }
  return views;
}

void AddCompared(const EvaluationResults& results, const CircleErrors& object, Panel* panel) {
  for (const Line& line : kComparedLines) {
    const std::optional<size_t> method = FindMethod(results, line.method_id);
    if (!method) continue;
    const bool runs = line.method_id == kParticleFilterId && !object.particle_runs_deg.empty();
    if (runs) {
      for (const std::vector<double>& run : object.particle_runs_deg) {
        panel->Add(run, "lines lw 0.6 lc rgb '#f3d699'", "");
      }
    }
    const std::string title =
        FigureText(MethodName(results.methods[*method]) + (runs ? " (mean)" : ""), kKeyLength);
    panel->Add(runs ? MeanOfRuns(object.particle_runs_deg) : object.step_symmetric_deg[*method],
               std::string("lines ") + line.style,
               title);
  }
}

Panel StepPanel(const EvaluationResults& results, size_t index, size_t place) {
  const CircleErrors& object = results.circle[index];
  Panel panel(place);
  AddCompared(results, object, &panel);
  panel.Add(RunningMean(object.detection_symmetric_deg),
            Format("lines lw 1.5 lc rgb '%s'", kDetectionColor),
            "'mean of the detections'");
  const std::optional<size_t> paper = FindMethod(results, kCwVwId);
  const std::optional<size_t> best = BestOurs(results);
  if (paper && paper != best) {
    panel.Add(object.step_symmetric_deg[*paper],
              "lines lw 2.2 lc rgb '#6da7dd'",
              FigureText(MethodName(results.methods[*paper]), kKeyLength));
  }
  if (best) {
    panel.Add(object.step_symmetric_deg[*best],
              Format("lines lw 3.4 lc rgb '%s'", kOursColor),
              FigureLabel(results.methods[*best], kKeyLength));
  }
  panel.Add(object.detection_symmetric_deg,
            Format("points pt 3 ps 0.6 lw 1.4 lc rgb '%s'", kDetectionColor),
            "'detections'");
  return panel;
}

}  // namespace

std::vector<size_t> StepObjects(const EvaluationResults& results) {
  std::vector<size_t> objects;
  for (const bool with_runs : {true, false}) {
    for (size_t i = 0; i < results.circle.size() && objects.size() < kStepObjects; ++i) {
      if (results.circle[i].particle_runs_deg.empty() != with_runs) objects.push_back(i);
    }
  }
  return objects;
}

std::vector<double> MeanOfRuns(const std::vector<std::vector<double>>& runs) {
  size_t views = 0;
  for (const std::vector<double>& run : runs) views = std::max(views, run.size());
  std::vector<double> means;
  for (size_t view = 0; view < views; ++view) {
    std::vector<double> errors;
    for (const std::vector<double>& run : runs) {
      if (view < run.size() && std::isfinite(run[view])) errors.push_back(run[view]);
    }
    means.push_back(errors.empty() ? kNone : Mean(errors));
  }
  return means;
}

std::vector<double> RunningMean(const std::vector<double>& values) {
  std::vector<double> means;
  double sum = 0.0;
  int count = 0;
  for (const double value : values) {
    if (std::isfinite(value)) {
      sum += value;
      ++count;
    }
    means.push_back(count == 0 ? kNone : sum / count);
  }
  return means;
}

Result<std::string> StepFigure(const EvaluationResults& results) {
  const std::vector<size_t> objects = StepObjects(results);
  if (objects.empty()) return std::string();
  std::vector<const std::vector<double>*> lines;
  for (const size_t index : objects) {
    const CircleErrors& object = results.circle[index];
    lines.push_back(&object.detection_symmetric_deg);
    for (size_t i = 0; i < results.methods.size(); ++i) {
      const std::string& id = results.methods[i].id;
      const bool drawn = id == results.best_ours || id == kCwVwId ||
                         std::any_of(kComparedLines.begin(),
                                     kComparedLines.end(),
                                     [&](const Line& line) { return id == line.method_id; });
      if (drawn) lines.push_back(&object.step_symmetric_deg[i]);
    }
    for (const std::vector<double>& run : object.particle_runs_deg) lines.push_back(&run);
  }
  constexpr int kHeight = 510;
  std::string key;
  std::string script = FigureHead(1120, kHeight) + "set multiplot\n" + ErrorRange(lines) +
                       ViewAxis(MostViews(results)) + "set xlabel 'views'\n";
  for (size_t i = 0; i < objects.size(); ++i) {
    const double left = 0.07 + 0.312 * static_cast<double>(i);
    script += PlacePanel({left, left + 0.285, 0.275, 0.92});
    script += i == 0 ? "set ylabel 'error modulo symmetry (degrees)'\n"
                     : "unset ylabel\nset format y ''\n";
    const Panel panel = StepPanel(results, objects[i], i);
    script +=
        "set title " + FigureText(results.circle[objects[i]].model_id, 24) + "\n" + panel.Script();
    // The lines are the same in all panels.
    if (i == 0) key = panel.Key(kHeight, 3);
  }
  script += key;
  return RunGnuplot(script + "unset multiplot\n");
}

Result<std::string> ObjectsFigure(const EvaluationResults& results) {
  const std::optional<size_t> best = BestOurs(results);
  if (results.circle.empty() || !best) return std::string();
  constexpr size_t kColumns = 4;
  const size_t rows = (results.circle.size() + kColumns - 1) / kColumns;
  const int height = 105 + 185 * static_cast<int>(rows);
  std::vector<const std::vector<double>*> lines;
  for (const CircleErrors& object : results.circle) {
    lines.push_back(&object.detection_symmetric_deg);
    lines.push_back(&object.step_symmetric_deg[*best]);
  }
  std::string key;
  std::string script = FigureHead(1120, height, 13) + "set multiplot\n" + ErrorRange(lines) +
                       ViewAxis(MostViews(results));
  const double panel = 185.0 / height;
  for (size_t i = 0; i < results.circle.size(); ++i) {
    const CircleErrors& object = results.circle[i];
    const size_t row = i / kColumns;
    const size_t column = i % kColumns;
    const bool lowest = i + kColumns >= results.circle.size();
    const double left = 0.075 + 0.233 * static_cast<double>(column);
    const double top = 1.0 - 26.0 / height - panel * static_cast<double>(row);
    script += PlacePanel({left, left + 0.215, top - 145.0 / height, top});
    script += column == 0 ? "set ylabel 'error (degrees)'\nset format y '%g'\n"
                          : "unset ylabel\nset format y ''\n";
    script +=
        lowest ? "set xlabel 'views'\nset format x '%g'\n" : "unset xlabel\nset format x ''\n";
    Panel lines_and_points(i);
    lines_and_points.Add(object.detection_symmetric_deg,
                         Format("points pt 3 ps 0.5 lw 1.4 lc rgb '%s'", kDetectionColor),
                         "'detections'");
    lines_and_points.Add(object.step_symmetric_deg[*best],
                         Format("lines lw 2.6 lc rgb '%s'", kOursColor),
                         FigureLabel(results.methods[*best], kKeyLength));
    script += "set title " + FigureText(object.model_id, 24) + " offset 0,-0.6\n" +
              lines_and_points.Script();
    if (i == 0) key = lines_and_points.Key(height, 1);
  }
  script += key;
  return RunGnuplot(script + "unset multiplot\n");
}

}  // namespace vantage
