#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "common/result.h"
#include "fusion/object_tracker.h"
#include "nodes/config_reader.h"
#include "planner/view_sequence.h"

namespace vantage {

/// What [fusion], [planner] and [models] say.
struct FusionConfig {
  int k = 64;  ///< of the grid
  ObjectTrackerParameters tracker;
  ViewSequenceParameters views;
  std::filesystem::path state_file;  ///< empty: no state is kept
  std::map<std::string, TrackedModel> models;
  /// Names the models, with what is known of their orientations, and the candidates: a saved state
  /// of another set-up is of no use. Other parameters may change: what was seen is fused anew.
  std::string setup;
};

/// Reads the three tables and loads the models. Errors: ConfigReader::Finish(); a model that can't
/// be loaded; a likely pose of a model that is not in use, or all of a model's with weight 0.
Result<FusionConfig> ReadFusionConfig(ConfigReader& config);

}  // namespace vantage
