#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "common/result.h"
#include "fusion/confusion/confusion_model.h"
#include "fusion/confusion/contingency_table.h"
#include "nodes/config_reader.h"
#include "perception/model/object_model.h"

namespace vantage {

/// What [confusion] and [confusion.tables] say: which contingency tables weigh detections and lead
/// the camera.
struct ConfusionConfig {
  bool use = true;
  std::string estimator = "ppf";  ///< whose tables
  ConfusionModelParameters model;
  /// By model: a file, or "none". Models that are not listed have the one in their folder if there
  /// is one, see ConfusionFileName().
  std::map<std::string, std::string> tables;
};

/// "confusion-ppf.bin": the file of a table in a model's folder.
std::string ConfusionFileName(const std::string& estimator);

/// Reads the tables. Errors are kept by `config`.
ConfusionConfig ReadConfusionConfig(ConfigReader& config);

/// What a table must have been measured with to be of use in a set-up: the estimator's parameters
/// as its own table of the config says, and in a simulated set-up the sensor. The model's own part
/// is left empty. Tables of other processes are read as far as they can be; what is wrong in them
/// is theirs to tell.
struct ConfusionSetup {
  std::string estimator;
  std::string estimator_parameters;
  std::string sensor;  ///< lines that ContingencyKey::sensor must hold; empty: not known
};
ConfusionSetup ReadConfusionSetup(const ConfigReader& config, const std::string& estimator);

/// Loads a model's table. Nothing when none is wanted or none is there. Errors: a table that is
/// named and not there; one that can't be read, or was measured with another model, estimator or
/// sensor.
Result<std::shared_ptr<const ConfusionModel>> LoadConfusion(const ConfusionConfig& config,
                                                            const ConfusionSetup& setup,
                                                            const ObjectModel& model,
                                                            const std::filesystem::path& folder);

}  // namespace vantage
