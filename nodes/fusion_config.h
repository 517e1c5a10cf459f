#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

#include "common/result.h"
#include "common/triangle_mesh.h"
#include "fusion/object_tracker.h"
#include "nodes/config_reader.h"
#include "nodes/object_refinement.h"
#include "nodes/object_refinement_config.h"
#include "planner/view_sequence.h"

namespace vantage {

/// What the planner needs to know of a model beside its confusion.
struct PlannedShape {
  TriangleMesh mesh;    ///< m, coarse
  double radius = 0.1;  ///< m, of the ball about the center that holds it
};

/// What [fusion], [planner], [confusion] and [models] say.
struct FusionConfig {
  int k = 64;  ///< of the grid
  ObjectTrackerParameters tracker;
  ViewSequenceParameters views;
  std::string criterion = "information_gain";  ///< of the next view
  uint64_t criterion_seed = 1;                 ///< of "random"
  std::filesystem::path state_file;            ///< empty: no state is kept
  std::map<std::string, TrackedModel> models;
  std::map<std::string, PlannedShape> shapes;  ///< of each model
  ObjectRefinementConfig refinement;
  ObjectRefinement::Models refined_models;  ///< all of them where there is a camera to refine with
  /// By model: why the contingency table that there is for it is not used.
  std::map<std::string, std::string> refused_tables;
  /// Names the models, with what is known of their orientations, and the candidates: a saved state
  /// of another set-up is of no use. Other parameters may change: what was seen is fused anew.
  std::string setup;
};

/// Reads the tables and loads the models with their contingency tables. A contingency table that
/// is of no use is no error: the robot can go on without. Errors: ConfigReader::Finish(); a model
/// that can't be loaded; a likely pose or a table of a model that is not in use, or all of a
/// model's poses with weight 0.
Result<FusionConfig> ReadFusionConfig(ConfigReader& config);

}  // namespace vantage
