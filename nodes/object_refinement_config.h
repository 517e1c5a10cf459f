#pragma once

#include <cstddef>
#include <string>

#include "nodes/config_reader.h"
#include "perception/refinement/multi_view_parameters.h"

namespace vantage {

/// What [fusion.refinement] says.
struct ObjectRefinementConfig {
  std::string camera;   ///< <NAME> of the camera whose depth is used; empty: nothing is refined
  int most_views = 16;  ///< images that are kept
  /// Of the weight of all peaks that the first one must have for its mode to be settled.
  double settled_share = 0.9;
  double max_rotation = 3.0 * kDegree;  ///< rad, from the fused pose; farther is refused
  double max_translation = 0.005;       ///< m, likewise
  MultiViewParameters parameters;
};

/// Reads the table; errors wait for ConfigReader::Finish().
ObjectRefinementConfig ReadObjectRefinementConfig(ConfigReader& config);

}  // namespace vantage
