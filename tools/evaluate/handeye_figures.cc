#include "tools/evaluate/handeye_figures.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "common/format.h"
#include "tools/evaluate/figure_style.h"
#include "tools/support/gnuplot.h"

namespace vantage {
namespace {

constexpr int kShownViews = 30;
constexpr const char* kEyeToHandColor = "#d55e00";
/// What a method may be off that found nothing at all is cut here.
constexpr double kLargestDrawnMm = 3000.0;

const char* ColorOf(const std::string& setup) {
  return setup == "eye in hand" ? kOursColor : kEyeToHandColor;
}

std::vector<double> OutlierShares(const HandEyeResults& results) {
  std::vector<double> shares;
  for (const HandEyeCell& cell : results.cells) {
    if (std::find(shares.begin(), shares.end(), cell.outlier_share) == shares.end()) {
      shares.push_back(cell.outlier_share);
    }
  }
  return shares;
}

std::string RowLabels(const std::vector<std::string>& names) {
  std::string script;
  for (size_t row = 0; row < names.size(); ++row) {
    script +=
        "set label " + FigureText(names[row], 44) +
        Format(
            " at graph -0.03, first %zu right textcolor rgb '%s'\n", names.size() - row, kInkColor);
  }
  return script;
}

/// One panel of "errors": rows are methods.
std::string ErrorPanel(const HandEyeResults& results, double share, size_t panel, size_t panels) {
  const size_t num_methods = results.methods.size();
  const double left = 0.25;
  const double width = (0.98 - left) / static_cast<double>(panels);
  const double begin = left + width * static_cast<double>(panel);
  std::string script = PlacePanel({begin + 0.01, begin + width - 0.01, 0.25, 0.92});
  script += Format(
      "unset label\nset title '%.0f %% outliers'\nset logscale x\nset xrange [0.1:%g]\n"
      "set format x '%%g'\nset yrange [0.4:%zu.6]\nunset ytics\nset xlabel 'median error (mm)'\n",
      100.0 * share,
      kLargestDrawnMm,
      num_methods);
  if (panel == 0) script += RowLabels(results.methods);
  // The key is below the middle panel.
  script += panel == 1 ? "set key at screen 0.62, 0.04 center horizontal maxrows 1 samplen 1\n"
                       : "unset key\n";
  std::string plot;
  double offset = 0.14;
  for (const char* setup : {"eye in hand", "eye to hand"}) {
    const std::string name = Format("$p%zu%s", panel, offset > 0.0 ? "a" : "b");
    script += name + " << END\n";
    for (const HandEyeCell& cell : results.cells) {
      if (cell.setup != setup || cell.views != kShownViews || cell.outlier_share != share) continue;
      const auto method = std::find(results.methods.begin(), results.methods.end(), cell.method);
      const double row =
          static_cast<double>(num_methods) - static_cast<double>(method - results.methods.begin());
      const auto drawn = [](double value) { return DataNumber(std::min(value, kLargestDrawnMm)); };
      script += Format("%s %g %s %s\n",
                       drawn(cell.median_mm.value).c_str(),
                       row + offset,
                       drawn(cell.median_mm.low).c_str(),
                       drawn(cell.median_mm.high).c_str());
    }
    script += "END\n";
    plot += (plot.empty() ? "plot " : ", ") + name +
            Format(" using 1:2:3:4 with xerrorbars pt 7 ps 0.8 lw 1.6 lc rgb '%s' title '%s'",
                   ColorOf(setup),
                   setup);
    offset = -offset;
  }
  return script + plot + "\n";
}

std::string ErrorScript(const HandEyeResults& results) {
  const std::vector<double> shares = OutlierShares(results);
  std::string script = FigureHead(1120, 460) +
                       "set border 1 lc rgb '#888888'\nset grid xtics noytics\nset multiplot\n";
  for (size_t panel = 0; panel < shares.size(); ++panel) {
    script += ErrorPanel(results, shares[panel], panel, shares.size());
  }
  return script + "unset multiplot\n";
}

/// Rows are cells.
std::string CellName(const std::string& setup, int views, double share) {
  return Format("%s, %d views, %.0f %% outliers", setup.c_str(), views, 100.0 * share);
}

std::string RowsHead(size_t num_rows, const char* x_label, const char* x_range) {
  return FigureHead(900, 130 + 22 * static_cast<int>(num_rows), 13) +
         Format(
             "set border 1 lc rgb '#888888'\nset grid xtics noytics\nset lmargin 38\nunset ytics\n"
             "set key outside bottom center horizontal samplen 1\nset xlabel '%s'\nset xrange %s\n"
             "set yrange [0.4:%zu.6]\n",
             x_label,
             x_range,
             num_rows);
}

std::string Point(const Interval& interval, double factor, double y) {
  return Format("%s %g %s %s\n",
                DataNumber(factor * interval.value).c_str(),
                y,
                DataNumber(factor * interval.low).c_str(),
                DataNumber(factor * interval.high).c_str());
}

std::string BoundScript(const HandEyeResults& results) {
  std::vector<const HandEyeCell*> ours;
  std::vector<std::string> names;
  for (const HandEyeCell& cell : results.cells) {
    if (cell.method != results.methods.front()) continue;
    ours.push_back(&cell);
    names.push_back(CellName(cell.setup, cell.views, cell.outlier_share));
  }
  std::string script =
      RowsHead(ours.size(), "RMSE by the Cramer-Rao bound, 95 % interval", "[0.9:1.15]") +
      RowLabels(names) +
      Format(
          "set arrow from 1, 0.4 to 1, %zu.6 nohead lc rgb '#888888'\n"
          "set arrow from 1.05, 0.4 to 1.05, %zu.6 nohead dt 2 lc rgb '#888888'\n",
          ours.size(),
          ours.size());
  std::string translation = "$translation << END\n";
  std::string rotation = "$rotation << END\n";
  for (size_t row = 0; row < ours.size(); ++row) {
    const double y = static_cast<double>(ours.size() - row);
    translation += Point(ours[row]->ratio_translation, 1.0, y + 0.14);
    rotation += Point(ours[row]->ratio_rotation, 1.0, y - 0.14);
  }
  return script + translation + "END\n" + rotation + "END\n" +
         Format(
             "plot $translation using 1:2:3:4 with xerrorbars pt 7 ps 0.7 lw 1.6 lc rgb '%s' "
             "title 'translation', $rotation using 1:2:3:4 with xerrorbars pt 5 ps 0.7 lw 1.6 "
             "lc rgb '%s' title 'rotation'\n",
             kOursColor,
             kEyeToHandColor);
}

std::string CoverageScript(const HandEyeResults& results) {
  const size_t num_rows = results.self_tests.size();
  std::vector<std::string> names;
  std::string data = "$coverage << END\n";
  for (size_t row = 0; row < num_rows; ++row) {
    const HandEyeSelfTest& test = results.self_tests[row];
    names.push_back(CellName(test.setup, test.views, test.outlier_share));
    data += Point(test.coverage, 100.0, static_cast<double>(num_rows - row));
  }
  return RowsHead(num_rows, "trials whose 95 % ellipsoid holds the truth (%)", "[90:100]") +
         RowLabels(names) +
         Format(
             "set object rectangle from 93, 0.4 to 97, %zu.6 behind fc rgb '#eef1f4' fs solid "
             "noborder\nset arrow from 95, 0.4 to 95, %zu.6 nohead lc rgb '#888888'\n",
             num_rows,
             num_rows) +
         data +
         Format(
             "END\nplot $coverage using 1:2:3:4 with xerrorbars pt 7 ps 0.8 lw 1.6 lc rgb '%s' "
             "notitle\n",
             kOursColor);
}

}  // namespace

Result<ReportFigures> DrawHandEyeFigures(const HandEyeResults& results) {
  ReportFigures figures;
  const std::pair<const char*, std::string> scripts[] = {{"errors", ErrorScript(results)},
                                                         {"bound", BoundScript(results)},
                                                         {"coverage", CoverageScript(results)}};
  for (const auto& [name, script] : scripts) {
    Result<std::string> figure = RunGnuplot(script);
    if (!figure) return figure.error();
    figures[name] = std::move(*figure);
  }
  return figures;
}

}  // namespace vantage
