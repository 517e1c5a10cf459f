#pragma once

#include <vector>

#include "common/rng.h"
#include "common/so3.h"
#include "common/symmetry_group.h"
#include "perception/ppf/ppf_table.h"
#include "perception/refinement/nearest_grid.h"
#include "perception/verification/model_view.h"

namespace vantage {

/// Rigid motions T that bring most of a model's surface onto itself, without those of its symmetry
/// group: 2-fold but for a small boss, or continuous but for a handle. A hypothesis in such a pose
/// is nearly as good as the true one, so wherever one is found the others must be held against the
/// image too. Found by matching the model with itself.
std::vector<Pose> FindSelfAlignments(const PpfTable& table,
                                     const NearestGrid& grid,
                                     const ModelShape& model,
                                     const SymmetryGroup& symmetry,
                                     Rng& rng);

}  // namespace vantage
