#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>

#include "common/result.h"
#include "common/symmetry_group.h"
#include "fusion/confusion/contingency_table.h"
#include "fusion/confusion/direction_grid.h"
#include "fusion/confusion/stopping_rule.h"
#include "fusion/so3_grid.h"
#include "tools/contingency/trial_units.h"
#include "tools/contingency/work_file.h"

namespace vantage {

/// One trial: what is detected of an object in this orientation, by the seed alone. As
/// TrialSimulator::Detect.
using TrialDetector = std::function<std::optional<Eigen::Quaterniond>(
    const Eigen::Quaterniond& q_camera_object, uint64_t seed)>;
/// Makes a detector for one thread. Called by several threads at once.
using TrialDetectorFactory = std::function<Result<TrialDetector>()>;

/// How the trials of one unit are drawn and when they are enough.
struct TrialPlan {
  std::string model_id;
  uint64_t seed = 1;
  SymmetryGroup symmetry;
  StoppingParameters stopping;  ///< of directions; rows have always most_trials
};

/// Trials from one cell of viewing directions: the direction is uniform in the cell and the roll
/// about the optical axis uniform, or one and the same (rad), which has trials of its own.
/// Depends on the arguments alone.
DirectionTrials MeasureDirection(const TrialPlan& plan,
                                 const DirectionGrid& grid,
                                 int direction,
                                 std::optional<double> roll,
                                 const TrialDetector& detect);
/// Trials of a row (paper 6.2): the truth is the cell's representative orientation.
RowTrials MeasureRow(const TrialPlan& plan,
                     const So3Grid& grid,
                     int32_t ordinal,
                     const TrialDetector& detect);

struct MeasureProgress {
  int64_t units_done = 0;
  int64_t units_total = 0;
};

/// Measures those units that the work file does not hold, each on one thread, and appends them.
/// What the file then holds does not depend on threads, order or interruptions.
/// @param threads >= 1.
/// @param progress may be empty; called by one thread at a time.
/// @return false when it ended before all was done because of `stop`; units in work are finished.
/// Errors: the first of the factory's or the file's.
Result<bool> MeasureTable(const TrialPlan& plan,
                          const TrialUnits& units,
                          int threads,
                          const TrialDetectorFactory& make_detector,
                          const std::stop_token& stop,
                          const std::function<void(const MeasureProgress&)>& progress,
                          WorkFile* work);

}  // namespace vantage
