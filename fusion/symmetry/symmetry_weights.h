#pragma once

#include <cstdint>
#include <vector>

#include "common/result.h"
#include "common/triangle_mesh.h"
#include "fusion/confusion/contingency_table.h"
#include "fusion/so3_grid.h"

namespace vantage {

/// W_s(q') of a difference rotation (paper 6.3); those that are not listed weigh nothing.
struct SymmetryWeight {
  So3Grid::Cell cell = 0;
  double weight = 0.0;
};

/// Paper eq. 12 and 13: the share of detections with the difference q' = q_GT* q_D, every viewing
/// direction (and every row, of a table by rows) counting alike. Ascending by cell; they sum to 1.
/// Error: a table in which nothing was detected.
Result<std::vector<SymmetryWeight>> TableSymmetryWeights(const ContingencyTable& table,
                                                         const So3Grid& grid);

/// Paper eq. 14 for every representative orientation: exp(-MSE^2 / 2 sigma_mse^2), about the
/// surface's centroid. Ascending by cell, in [0, 1].
/// @param sigma the root of sigma_mse, in diameters of the object: a cell is a few degrees wide,
///        which alone moves a surface by some hundredths.
std::vector<SymmetryWeight> MeshSymmetryWeights(const TriangleMesh& mesh,
                                                const So3Grid& grid,
                                                double sigma = 0.03,
                                                uint64_t seed = 1);

}  // namespace vantage
