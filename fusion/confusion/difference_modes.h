#pragma once

#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "common/symmetry_group.h"
#include "fusion/confusion/contingency_table.h"

namespace vantage {

/// Difference rotations sorted into modes: places, a radius apart, that many of them are near.
struct DifferenceModes {
  struct Count {
    int mode = 0;
    int count = 0;  ///< > 0
  };

  std::vector<Eigen::Quaterniond> differences;  ///< q' of each mode; the identity is the first
  std::vector<std::vector<Count>> counts;       ///< by direction, ascending by mode
};

/// Greedy: the heaviest place that is in no mode yet is the next one, at the mean of the
/// differences about it. Differences are modulo the group on the right, each mode's is the one
/// nearest to the identity. At most kMostModes, each of kFewestDetections or more; what is in none
/// is not in the counts.
/// @param radius rad, of a mode. @param directions with counts > 0.
DifferenceModes FindDifferenceModes(std::span<const DirectionTrials> directions,
                                    const SymmetryGroup& symmetry,
                                    double radius);

inline constexpr int kMostModes = 128;
inline constexpr int kFewestDetections = 3;

}  // namespace vantage
