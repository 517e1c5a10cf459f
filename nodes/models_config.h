#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/result.h"
#include "nodes/config_reader.h"

namespace vantage {

/// What [models] says: which objects there may be. Estimators, fusion and reports read it alike.
struct ModelsConfig {
  std::filesystem::path folder;  ///< with one folder a model
  std::vector<std::string> use;  ///< names of these; empty: all
};

/// Reads the table. Errors wait for ConfigReader::Finish(): no folder; a list that is empty or
/// names what can't be a model, or one model twice.
ModelsConfig ReadModelsConfig(ConfigReader& config);

/// Names of the models in use: as listed, or all of the folder in alphabetical order.
/// Errors: no such folder, no model in it, a name that is not there.
Result<std::vector<std::string>> FindModels(const ModelsConfig& models);

}  // namespace vantage
