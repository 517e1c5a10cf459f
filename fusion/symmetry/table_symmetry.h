#pragma once

#include "common/result.h"
#include "fusion/confusion/contingency_table.h"
#include "fusion/symmetry/found_symmetry.h"

namespace vantage {

struct TableSymmetryParameters {
  int k = 16;  ///< of the grid of the symmetry weights, 2..32
  /// Share of the heaviest cell's weight from which a cell is heavy, in (0, 1).
  double heavy = 0.05;
  /// Share of the detections from which a cluster of heavy cells is told, in (0, 1).
  double least_weight = 0.01;
  /// Share of the viewing directions from which a rotation must be taken for none to be a
  /// symmetry, in (0, 1).
  double directions = 0.9;

  [[nodiscard]] Result<void> Validate() const;
};

/// The rotations that an estimator takes for none (paper 6.3, eq. 12 and 13): heavy cells of the
/// symmetry weights are clustered, and each cluster is one rotation, or all rotations about an axis
/// where its Bingham distribution lies along a circle, or all there are. Those that occur from
/// nearly every viewing direction make the group; the others are confusions, with their share of
/// the directions. A table says nothing of where axes pass: `center` stays 0.
/// Errors: parameters, a table without detections by direction.
Result<FoundSymmetry> SymmetryOfTable(const ContingencyTable& table,
                                      const TableSymmetryParameters& parameters = {});

}  // namespace vantage
