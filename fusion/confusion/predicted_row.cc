#include "fusion/confusion/predicted_row.h"

#include <map>

namespace vantage {

RowTrials PredictedRow(const DirectionTrials& direction,
                       const So3Grid& grid,
                       const Eigen::Quaterniond& q_camera_object) {
  std::map<int32_t, int32_t> counts;
  for (const DifferenceCount& difference : direction.differences) {
    const Eigen::Quaterniond q_detected = q_camera_object * difference.Difference();
    counts[grid.Ordinal(grid.CellOf(q_detected))] += difference.count;
  }
  RowTrials row;
  row.trials = direction.trials;
  row.missed = direction.missed;
  row.detected.reserve(counts.size());
  for (const auto& [ordinal, count] : counts) row.detected.push_back({ordinal, count});
  return row;
}

}  // namespace vantage
