#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/result.h"
#include "drivers/sim/scene.h"
#include "perception/model/object_model.h"

namespace vantage {

/// Where an object truly is.
struct TruthObject {
  std::string model_id;
  Pose T_world_object = Pose::Identity();
};

/// What a run is judged by.
struct ReportSetup {
  std::string camera;                         ///< the <NAME> of the channels
  std::map<std::string, ObjectModel> models;  ///< by id: those of [models], and of the truth
  std::vector<TruthObject> truth;             ///< of [sim]; empty when nothing is known
  std::optional<SimPlane> table;              ///< of [sim.table]
};

/// Reads [ppf], [models] and, if it is there, [sim] of a configuration, and loads the models.
/// Errors: the config; a model that can't be loaded.
Result<ReportSetup> LoadReportSetup(const std::filesystem::path& config_file);

/// A file with T_world_object, 4 x 4 numbers, row-major, m. Errors: absent, other than 16 finite
/// numbers, farther than 0.05 from a rotation, a last row other than 0 0 0 1.
Result<TruthObject> ReadTruthMatrix(const std::filesystem::path& file, const std::string& model_id);

}  // namespace vantage
