#include "tools/evaluate/figure_boxes.h"

#include <algorithm>

#include "common/format.h"
#include "tools/evaluate/figure_style.h"
#include "tools/evaluate/paper_figures.h"
#include "tools/evaluate/report_numbers.h"
#include "tools/support/gnuplot.h"

namespace vantage {
namespace {

struct BoxData {
  std::string boxes;     ///< row, whiskers, quartiles, median, color
  std::string outliers;  ///< error, row, color
  std::string paper;     ///< least and greatest median, row
  double least = kMissingErrorDeg;
  double greatest = kSmallestDrawnDeg;
  std::vector<double> upper_quartiles;
};

BoxData MakeBoxes(const EvaluationResults& results, bool symmetric) {
  BoxData data;
  for (size_t i = 0; i < results.methods.size(); ++i) {
    std::vector<double> finals = WithMissing(CircleFinals(results, i, symmetric));
    for (double& error : finals) error = DrawnError(error);
    const BoxSummary box = SummarizeBox(finals);
    const double row = RowOfMethod(results, i);
    const char* color = MethodColor(results.methods[i]) + 1;
    data.boxes += Format("%g %g %g %g %g %g 0x%s\n",
                         row,
                         box.lower_whisker,
                         box.lower_quartile,
                         box.median,
                         box.upper_quartile,
                         box.upper_whisker,
                         color);
    for (const double outlier : box.outliers) {
      data.outliers += Format("%g %g 0x%s\n", outlier, row, color);
    }
    if (const PaperBox* paper = FindPaperBox(results.methods[i].id)) {
      data.paper += Format("%g %g %g\n", paper->median_low_deg, paper->median_high_deg, row);
      data.least = std::min(data.least, paper->median_low_deg);
      data.greatest = std::max(data.greatest, paper->median_high_deg);
    }
    data.least = std::min(data.least, *std::min_element(finals.begin(), finals.end()));
    data.greatest = std::max(data.greatest, *std::max_element(finals.begin(), finals.end()));
    data.upper_quartiles.push_back(box.upper_quartile);
  }
  return data;
}

constexpr const char* kPlot =
    "plot $boxes using 2:1:($3-$2):(0):7 with vectors nohead lw 1.5 lc rgb variable, "
    "$boxes using 5:1:($6-$5):(0):7 with vectors nohead lw 1.5 lc rgb variable, "
    "$boxes using 4:1:3:5:($1-0.3):($1+0.3):7 with boxxyerror lc rgb variable "
    "fs transparent solid 0.3 border, "
    "$boxes using 4:($1-0.3):(0):(0.6):7 with vectors nohead lw 3 lc rgb variable";

}  // namespace

Result<std::string> BoxFigure(const EvaluationResults& results, bool symmetric) {
  if (results.circle.empty() || results.methods.empty()) return std::string();
  const BoxData data = MakeBoxes(results, symmetric);
  const int height = 110 + 29 * static_cast<int>(results.methods.size());
  const double bottom = 62.0 / height;
  const double top = 1.0 - 38.0 / height;
  std::string plot = kPlot;
  std::string script = FigureHead(1120, height) + "set border 1 lc rgb '#888888'\n$boxes << END\n" +
                       data.boxes + "END\n";
  if (!data.outliers.empty()) {
    script += "$outliers << END\n" + data.outliers + "END\n";
    plot += ", $outliers using 1:2:3 with points pt 6 ps 0.5 lw 1.2 lc rgb variable";
  }
  if (!data.paper.empty()) {
    script += "$paper << END\n" + data.paper + "END\n";
    plot += Format(
        ", $paper using 1:3:($2-$1):(0) with vectors nohead lw 2 lc rgb '%s', "
        "$paper using (($1+$2)/2):3 with points pt 13 ps 0.9 lc rgb '%s'",
        kDetectionColor,
        kDetectionColor);
  }
  // At least half of the boxes are whole in the zoomed plot.
  const double zoom = 1.25 * std::max(Median(data.upper_quartiles), 0.01);
  const char* unit = symmetric ? "degrees, modulo symmetry" : "degrees";
  script += "set multiplot\n" + PlacePanel({0.205, 0.59, bottom, top}) + MethodRows(results, true) +
            Format("set title 'all errors'\nset xlabel 'final error (%s)'\n", unit) +
            LogarithmicRange('x', data.least, data.greatest) + plot + "\n";
  script += PlacePanel({0.615, 0.985, bottom, top}) + MethodRows(results, false) +
            Format("unset logscale x\nset title 'up to %.2g°'\nset xrange [0:%g]\n", zoom, zoom) +
            plot + "\n";
  return RunGnuplot(script + "unset multiplot\n");
}

}  // namespace vantage
