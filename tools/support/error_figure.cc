#include "tools/support/error_figure.h"

#include <algorithm>
#include <optional>
#include <vector>

#include "common/format.h"
#include "tools/support/gnuplot.h"

namespace vantage {
namespace {

constexpr double kSmallestAngle = 0.01;  // deg; what is less is drawn there.

void AppendData(const std::string& name,
                const std::vector<std::optional<PoseError>>& errors,
                std::string* script) {
  *script += "$" + name + " << END\n";
  for (size_t i = 0; i < errors.size(); ++i) {
    if (!errors[i]) continue;
    *script += Format("%zu %g\n", i + 1, std::max(kSmallestAngle, errors[i]->angle / kDegree));
  }
  *script += "END\n";
}

bool HasErrors(const std::vector<std::optional<PoseError>>& errors) {
  return std::any_of(errors.begin(), errors.end(), [](const auto& error) { return error; });
}

}  // namespace

Result<std::string> ErrorFigure(const RunMetrics& metrics, const std::vector<Rgb>& colors) {
  std::string script =
      "set terminal svg noenhanced size 860,400 dynamic font 'sans-serif,15' background "
      "'#ffffff'\n"
      "set logscale y\nset grid ytics lc rgb '#dddddd'\nset border 3 lc rgb '#888888'\n"
      "set tics nomirror textcolor rgb '#555555'\n"
      "set xlabel 'view'\nset ylabel 'orientation error (degrees)'\n"
      "set key outside center top horizontal\nset offsets 0.3, 0.3, 0, 0\nset format y '%g'\n";
  std::string plots;
  size_t views = 0;
  for (size_t i = 0; i < metrics.objects.size(); ++i) {
    const ObjectHistory& object = metrics.objects[i];
    views = std::max(views, object.fused.size());
    const std::string color = HexColor(colors[i]);
    if (HasErrors(object.detected)) {
      AppendData(Format("detected%zu", i), object.detected, &script);
      plots += Format("%s$detected%zu using 1:2 with points pt 6 ps 0.9 lw 1.5 lc rgb '%s' notitle",
                      plots.empty() ? "" : ", ",
                      i,
                      color.c_str());
    }
    if (HasErrors(object.fused)) {
      AppendData(Format("fused%zu", i), object.fused, &script);
      plots +=
          Format("%s$fused%zu using 1:2 with linespoints pt 7 ps 0.6 lw 2.5 lc rgb '%s' title '%s'",
                 plots.empty() ? "" : ", ",
                 i,
                 color.c_str(),
                 object.model_id.c_str());
    }
    if (HasErrors(object.refined)) {
      AppendData(Format("refined%zu", i), object.refined, &script);
      plots += Format(
          "%s$refined%zu using 1:2 with linespoints pt 9 ps 0.7 lw 1.5 dt 2 lc rgb '%s' notitle",
          plots.empty() ? "" : ", ",
          i,
          color.c_str());
    }
  }
  if (plots.empty()) return std::string();
  script += Format("set xtics %zu\nset xrange [1:%zu]\nplot %s\n",
                   views > 16 ? size_t{5} : size_t{1},
                   std::max<size_t>(views, 2),
                   plots.c_str());
  return RunGnuplot(script);
}

}  // namespace vantage
