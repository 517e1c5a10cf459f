#pragma once

#include <string>
#include <vector>

#include "nodes/config_reader.h"
#include "planner/view_sequence.h"

namespace vantage {

/// What [planner] and [[planner.keep_out]] say.
struct PlannerConfig {
  std::string criterion = "information_gain";  ///< one of CriterionNames()
  uint64_t seed = 1;                           ///< of the criterion "random"
  ViewSequenceParameters views = DefaultViews();

  /// Candidates enough that the best of them is near the best there is.
  static ViewSequenceParameters DefaultViews() {
    ViewSequenceParameters views;
    views.candidates.count = 500;
    return views;
  }
};

/// Names of all next-best-view criteria.
std::vector<std::string> CriterionNames();

/// Reads the tables; `viewpoint` and `frames_per_view` are of [fusion]. Errors are kept by
/// `config`.
PlannerConfig ReadPlannerConfig(ConfigReader& config);

}  // namespace vantage
