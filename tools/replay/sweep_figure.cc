#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "common/format.h"
#include "tools/replay/sweep_report.h"
#include "tools/support/color.h"
#include "tools/support/gnuplot.h"

namespace vantage {
namespace {

constexpr size_t kMostNamedLines = 12;  // More have no names: a legend would hide the plot.

// A text for gnuplot, in single quotes.
std::string Quoted(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text.substr(0, 60)) {
    if (static_cast<unsigned char>(c) < 0x20) continue;
    quoted += c;
    if (c == '\'') quoted += c;
  }
  return quoted + "'";
}

std::optional<double> AsNumber(const std::string& literal) {
  char* end = nullptr;
  const double value = std::strtod(literal.c_str(), &end);
  if (literal.empty() || *end != '\0' || !std::isfinite(value)) return std::nullopt;
  return value;
}

// Where the values of the first parameter are drawn: at their value, else evenly with their names.
struct Axis {
  std::vector<double> places;
  std::string script;
};

Axis MakeAxis(const SweepParameter& parameter) {
  Axis axis;
  for (const std::string& literal : parameter.literals) {
    const std::optional<double> value = AsNumber(literal);
    if (!value) break;
    axis.places.push_back(*value);
  }
  axis.script =
      "set xlabel " + Quoted(parameter.key) + "\nset offsets graph 0.06, graph 0.06, 0, 0\n";
  if (axis.places.size() == parameter.literals.size()) return axis;
  axis.places.clear();
  std::string names;
  for (size_t i = 0; i < parameter.literals.size(); ++i) {
    axis.places.push_back(static_cast<double>(i));
    names += (i == 0 ? "" : ", ") + Quoted(parameter.literals[i]) + Format(" %zu", i);
  }
  axis.script += "set xtics (" + names + ")\n";
  return axis;
}

std::string DataNumber(double value) {
  return std::isfinite(value) ? Format("%.6g", value) : "NaN";
}

struct Line {
  std::string name;
  std::string title;
  std::string color;
  int dash = 1;
};

// One panel of two: the errors of a kind.
std::string Panel(const char* title,
                  const std::vector<Line>& lines,
                  int column,
                  bool with_names,
                  bool with_intervals) {
  std::string script = Format("set ylabel '%s'\nplot ", title);
  for (size_t i = 0; i < lines.size(); ++i) {
    const Line& line = lines[i];
    script += Format("%s$%s using 1:%d with lines lt 1 dt %d lw 2 lc rgb '%s' ",
                     i == 0 ? "" : ", ",
                     line.name.c_str(),
                     column,
                     line.dash,
                     line.color.c_str());
    script +=
        !with_names || lines.size() > kMostNamedLines ? "notitle" : "title " + Quoted(line.title);
    script += Format(", $%s using 1:%d", line.name.c_str(), column);
    if (with_intervals) script += Format(":%d:%d", column + 1, column + 2);
    script += Format(" with %s lt 1 pt 7 ps 0.6 lw 1.2 lc rgb '%s' notitle",
                     with_intervals ? "yerrorbars" : "points",
                     line.color.c_str());
  }
  return script + "\n";
}

}  // namespace

Result<std::string> SweepFigure(const SweepGrid& grid, const std::vector<SweepCell>& cells) {
  const Axis axis = MakeAxis(grid.parameters.front());
  const size_t num_places = axis.places.size();
  const size_t num_lines = cells.size() / num_places;
  std::string script =
      "set terminal svg noenhanced size 1000,440 dynamic font 'sans-serif,14' background "
      "'#ffffff'\n"
      "set grid ytics lc rgb '#dddddd'\nset border 3 lc rgb '#888888'\n"
      "set tics nomirror textcolor rgb '#555555'\nset yrange [0:*]\nset format y '%g'\n"
      "set multiplot layout 1,2\n" +
      axis.script;
  std::vector<Line> lines;
  for (size_t line = 0; line < num_lines; ++line) {
    std::string others;
    const std::vector<ConfigOverride> overrides = grid.Overrides(line);
    for (size_t i = 1; i < overrides.size(); ++i) {
      others += (others.empty() ? "" : ", ") + overrides[i].key + " " + overrides[i].literal;
    }
    for (const bool refined : {false, true}) {
      std::string data;
      bool any = false;
      for (size_t place = 0; place < num_places; ++place) {
        const SweepCell& cell = cells[place * num_lines + line];
        const SweepErrors& errors = refined ? cell.refined : cell.fused;
        any = any || std::isfinite(errors.rotation_deg.value);
        data += DataNumber(axis.places[place]);
        for (const Interval* each : {&errors.rotation_deg, &errors.position_mm}) {
          for (const double value : {each->value, each->low, each->high}) {
            data += ' ';
            data += DataNumber(value);
          }
        }
        data += '\n';
      }
      if (refined && !any) continue;
      const std::string name = Format("%s%zu", refined ? "refined" : "fused", line);
      script += Format("$%s << END\n", name.c_str()) + data + "END\n";
      lines.push_back({name,
                       (refined ? "refined " : "fused ") + others,
                       HexColor(ObjectColor(line)),
                       refined ? 2 : 1});
    }
  }
  // One legend above both panels, which begin at the same height.
  const size_t num_names = lines.size() > kMostNamedLines ? 0 : lines.size();
  script += Format("set key at screen 0.5, 0.99 center top\nset tmargin at screen %.3f\n",
                   0.95 - 0.048 * static_cast<double>(num_names));
  const bool with_intervals = !cells.empty() && cells.front().logs.size() > 1;
  script += Panel("median orientation error (degrees)", lines, 2, true, with_intervals);
  script += Panel("median position error (mm)", lines, 5, false, with_intervals);
  return RunGnuplot(script + "unset multiplot\n");
}

}  // namespace vantage
