#pragma once

#include <functional>
#include <span>
#include <stop_token>

#include "fusion/orientation_filter.h"
#include "fusion/so3_grid.h"
#include "tools/evaluate/evaluation_results.h"
#include "tools/evaluate/method_run.h"

namespace vantage {

/// Fig. 8: the final orientation by confidence and verification weighted clustering after the last
/// view of every sequence, for w_min and w_max in steps of 0.1, and 0.95. NaN where w_min > w_max.
/// The same for any number of threads.
/// @param parameters sigma_cw and sigma_vw are used.
ClusteringSweep SweepClustering(const So3Grid& grid,
                                const OrientationFilterParameters& parameters,
                                std::span<const EvaluatedSequence> sequences,
                                double wrong_mode_deg,
                                int threads,
                                const std::stop_token& stop);

}  // namespace vantage
