#include "tools/evaluate/figure_grid.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "common/format.h"
#include "tools/evaluate/figure_style.h"
#include "tools/evaluate/paper_figures.h"
#include "tools/support/color.h"
#include "tools/support/gnuplot.h"

namespace vantage {
namespace {

std::string BinData(const char* name, const BinCounts& bins, const std::vector<double>& expected) {
  std::string data = Format("$%s << END\n", name);
  for (size_t i = 0; i < bins.counts.size(); ++i) {
    data += Format("%g %lld %s\n",
                   (static_cast<double>(i) + 0.5) * bins.bin_width_deg,
                   static_cast<long long>(bins.counts[i]),
                   expected.empty() ? "NaN" : DataNumber(expected[i]).c_str());
  }
  return data + "END\n";
}

// From the first to the last bin with a count.
std::string FilledRange(const BinCounts& bins) {
  const auto filled = [](int64_t count) { return count > 0; };
  const auto first = std::find_if(bins.counts.begin(), bins.counts.end(), filled);
  const auto last = std::find_if(bins.counts.rbegin(), bins.counts.rend(), filled);
  if (first == bins.counts.end()) return "set xrange [*:*]\n";
  return Format("set xrange [%g:%g]\n",
                static_cast<double>(first - bins.counts.begin() - 1) * bins.bin_width_deg,
                static_cast<double>(bins.counts.rend() - last + 1) * bins.bin_width_deg);
}

// Dark where the value is large, on a logarithmic scale if it spans decades.
class Shade {
 public:
  Shade(const std::vector<std::vector<double>>& values, double least) : least_(least) {
    for (const std::vector<double>& row : values) {
      for (const double value : row) {
        if (!std::isfinite(value)) continue;
        low_ = std::min(low_, Scale(value));
        high_ = std::max(high_, Scale(value));
      }
    }
  }
  [[nodiscard]] double Share(double value) const {
    return high_ > low_ ? (Scale(value) - low_) / (high_ - low_) : 0.0;
  }

 private:
  [[nodiscard]] double Scale(double value) const { return std::log(std::max(value, least_)); }
  double least_;
  double low_ = 1e300;
  double high_ = -1e300;
};

// `half`: of the frame's side.
std::string Frame(double column, double row, double half, const char* style) {
  return Format(
      "set object rectangle from first %g, first %g to first %g, first %g front fs empty border "
      "lc rgb '%s' %s\n",
      column - half,
      row - half,
      column + half,
      row + half,
      kDetectionColor,
      style);
}

std::string Frames(const ClusteringSweep& sweep) {
  std::string script;
  double least = 1e300;
  size_t best_row = 0;
  size_t best_column = 0;
  for (size_t i = 0; i < sweep.w_min.size(); ++i) {
    for (size_t j = 0; j < sweep.w_max.size(); ++j) {
      if (std::abs(sweep.w_min[i] - kPaperSweepBest.w_min) < 1e-6 &&
          std::abs(sweep.w_max[j] - kPaperSweepBest.w_max) < 1e-6) {
        script += Frame(static_cast<double>(j), static_cast<double>(i), 0.38, "lw 2 dt 2");
      }
      if (!(sweep.mean_error_deg[i][j] < least)) continue;
      least = sweep.mean_error_deg[i][j];
      best_row = i;
      best_column = j;
    }
  }
  if (least == 1e300) return script;
  return script +
         Frame(static_cast<double>(best_column), static_cast<double>(best_row), 0.46, "lw 3");
}

std::string Tics(char axis, const std::vector<double>& values) {
  std::string text = Format("set %ctics (", axis);
  for (size_t i = 0; i < values.size(); ++i) {
    text += Format("%s'%g' %zu", i == 0 ? "" : ", ", values[i], i);
  }
  return text +
         Format(")\nset %crange [-0.5:%g]\n", axis, static_cast<double>(values.size()) - 0.5);
}

std::string HeatMap(const char* name,
                    const std::vector<std::vector<double>>& values,
                    const Shade& shade,
                    bool percent) {
  std::string cells;
  std::string texts;
  for (size_t i = 0; i < values.size(); ++i) {
    for (size_t j = 0; j < values[i].size(); ++j) {
      const double value = values[i][j];
      if (!std::isfinite(value)) continue;
      const double share = shade.Share(value);
      cells += Format("%zu %zu 0x%s\n", j, i, HexColor(DensityColor(share)).c_str() + 1);
      const std::string text = percent         ? Format("%.1f%%", 100.0 * value)
                               : value < 0.095 ? Format("%.3f", value)
                               : value < 9.95  ? Format("%.2f", value)
                                               : Format("%.0f", value);
      texts +=
          Format("%zu %zu \"%s\" 0x%s\n", j, i, text.c_str(), share > 0.55 ? "ffffff" : "1d2733");
    }
  }
  return Format("$%s << END\n", name) + cells + Format("END\n$%s_texts << END\n", name) + texts +
         "END\n" +
         Format(
             "plot $%s using 1:2:(0.48):(0.48):3 with boxxyerror fs solid noborder lc rgb "
             "variable, "
             "$%s_texts using 1:2:3:4 with labels font ',12' tc rgb variable\n",
             name,
             name);
}

}  // namespace

std::vector<double> UniformAngleCounts(const BinCounts& bins) {
  const double total =
      static_cast<double>(std::accumulate(bins.counts.begin(), bins.counts.end(), int64_t{0}));
  // Integral of the density (1 - cos theta) / pi from 0.
  const auto share = [](double angle) {
    const double theta = std::min(angle, std::numbers::pi);
    return (theta - std::sin(theta)) / std::numbers::pi;
  };
  const double width = bins.bin_width_deg * std::numbers::pi / 180.0;
  std::vector<double> expected;
  for (size_t i = 0; i < bins.counts.size(); ++i) {
    const double low = static_cast<double>(i) * width;
    expected.push_back(total * (share(low + width) - share(low)));
  }
  return expected;
}

Result<std::string> GridFigure(const EvaluationResults& results) {
  if (results.grid_angles.counts.empty() || results.grid_distances.counts.empty()) {
    return std::string();
  }
  std::string script =
      FigureHead(1120, 360) +
      BinData("angles", results.grid_angles, UniformAngleCounts(results.grid_angles)) +
      BinData("distances", results.grid_distances, {}) +
      "set multiplot\nset style fill solid 1 noborder\nset boxwidth 0.92 relative\n"
      "set yrange [0:*]\nset format y '%.0f'\nset ylabel 'orientations' offset 1\n";
  script += PlacePanel({0.085, 0.485, 0.19, 0.9}) +
            "set xrange [0:180]\nset xtics 30\nset key top left reverse Left samplen 2\n"
            "set xlabel 'angle of the orientation, θ (degrees)'\n" +
            Format(
                "plot $angles using 1:2 with boxes lc rgb '#8db4dc' title 'representatives', "
                "$angles using 1:3 with lines lw 2.5 lc rgb '%s' title 'sin²(θ/2)'\n",
                kDetectionColor);
  script += PlacePanel({0.585, 0.985, 0.19, 0.9}) + "unset key\nset xtics auto\n" +
            FilledRange(results.grid_distances) +
            "set xlabel 'distance to the nearest neighbor, d_nn (degrees)'\n"
            "plot $distances using 1:2 with boxes lc rgb '#8db4dc'\n";
  return RunGnuplot(script + "unset multiplot\n");
}

Result<std::string> SweepFigure(const EvaluationResults& results) {
  const ClusteringSweep& sweep = results.sweep;
  if (sweep.w_min.empty() || sweep.w_max.empty()) return std::string();
  const int height = 110 + 36 * static_cast<int>(sweep.w_min.size());
  const double bottom = 60.0 / height;
  const double top = 1.0 - 36.0 / height;
  std::string script = FigureHead(1120, height) +
                       "unset grid\nset border 0\nset tics scale 0\nset multiplot\n" +
                       Tics('x', sweep.w_max) + Tics('y', sweep.w_min) + Frames(sweep) +
                       "set xlabel 'w_max'\nset ylabel 'w_min' offset 1\n";
  script += PlacePanel({0.065, 0.495, bottom, top}) + "set title 'mean error (degrees)'\n" +
            HeatMap("errors", sweep.mean_error_deg, Shade(sweep.mean_error_deg, 1e-3), false);
  script += PlacePanel({0.56, 0.99, bottom, top}) + "set title 'wrong-mode rate'\n" +
            HeatMap("rates", sweep.wrong_mode_rate, Shade(sweep.wrong_mode_rate, 1e-3), true);
  return RunGnuplot(script + "unset multiplot\n");
}

}  // namespace vantage
