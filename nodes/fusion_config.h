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
  /// Names the models and candidates: a saved state of another set-up is of no use.
  std::string setup;
};

/// Reads the three tables and loads the models. Errors: ConfigReader::Finish(); a model that can't
/// be loaded.
Result<FusionConfig> ReadFusionConfig(ConfigReader& config);

}  // namespace vantage
