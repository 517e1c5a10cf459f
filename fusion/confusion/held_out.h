#pragma once

#include <span>

#include "fusion/confusion/contingency_table.h"

namespace vantage {

/// Mean log probability, nat, of the outcomes of held-out trials of one truth under a row measured
/// by other trials: P(cell) = (count + a) / (trials + a (num_cells + 1)), a missed detection being
/// one more cell. For a model by viewing direction the row is PredictedRow's. 0 for no held-out
/// trials.
/// @param num_cells So3Grid::num_cells of both rows' grid. @param pseudo_count a > 0.
double HeldOutLogLikelihood(const RowTrials& row,
                            const RowTrials& held_out,
                            int num_cells,
                            double pseudo_count);

/// The pseudo-count under which each trial of the rows is likeliest given the others of its row
/// (leave one out), between 1e-6 and 1, found to 1 %: each model's own, so that neither is held
/// back by the other's.
double LeaveOneOutPseudoCount(std::span<const RowTrials> rows, int num_cells);

}  // namespace vantage
