#pragma once

#include "fusion/so3_grid.h"
#include "tools/evaluate/evaluation_results.h"

namespace vantage {

/// A line of Table 1 and what Fig. 4 shows of the same grid.
struct GridMeasurement {
  GridStatistics statistics;
  BinCounts angles;     ///< of the representatives from the identity, bins of 2 deg
  BinCounts distances;  ///< to their nearest neighbors, 40 bins up to twice the mean
};

/// Measures a grid: the angle of every representative to its nearest neighbor, cells that touch the
/// sphere in a point left out. Exact, yet searched for one representative of each kind alone:
/// exchanging coordinates and their signs maps the set of representatives onto itself.
GridMeasurement MeasureGrid(int k);

}  // namespace vantage
