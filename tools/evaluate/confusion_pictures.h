#pragma once

#include <vector>

#include "fusion/cell_weights.h"
#include "fusion/confusion/contingency_table.h"
#include "fusion/so3_grid.h"
#include "tools/evaluate/confusion_results.h"

namespace vantage {

/// How Fig. 5 is drawn.
struct ConfusionMatrixView {
  int block = 10;               ///< cells of the table in one pixel, along both sides
  bool is_marking_any = false;  ///< every entry other than 0 at the maximum (Fig. 5, right)
};

/// The contingency table as a picture (Fig. 5): rows are ground truth orientations, columns
/// detected ones, by their ordinals. A pixel has the largest share of its block. A row measured by
/// itself is drawn as measured, the others follow from the trials of their viewing direction: q_D =
/// q_GT q'.
RgbImage DrawConfusionMatrix(const ContingencyTable& table,
                             const So3Grid& grid,
                             const ConfusionMatrixView& view);

/// Symmetry weights (Fig. 6): how often each difference rotation q' was seen, as the points q' v1
/// of the unit sphere. @param least_angle rad, of the rotations that are shown.
RgbImage DrawSymmetryWeights(const ContingencyTable& table, double least_angle);

/// The cells of a histogram as points (q_truth* q_r) v1: the truth is at (1, 1, 1) / sqrt(3).
RgbImage DrawHistogram(const CellWeights& weights, const Eigen::Quaterniond& q_truth);

}  // namespace vantage
