#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/result.h"
#include "nodes/config_reader.h"
#include "perception/ppf/ppf_estimator.h"

namespace vantage {

/// What [ppf], [models], [segmentation], [verification] and [refinement] say.
struct PpfConfig {
  std::string camera;            ///< the <NAME> of the channels
  uint64_t seed = 1;             ///< of all random choices
  double rest_window_s = 0.15;   ///< s before and after an image in which the camera rests
  std::filesystem::path models;  ///< folder with one folder a model
  std::vector<std::string> use;  ///< names of these; empty: all
  PpfEstimatorParameters estimator;
};

/// Reads the tables; all other processes' tables are left alone. `camera` may be left out when
/// there is one table [camera.<NAME>].
/// Errors: the first of the whole file, also of keys that nobody knows.
Result<PpfConfig> ReadPpfConfig(ConfigReader& config);

/// The models of `folder` named in `use`, or all, with their matching tables: those in the folder
/// if they fit, trained otherwise.
/// Errors: no such folder, no model in it, a name that is not there, a model that can't be read.
Result<std::vector<PpfEstimator::Model>> LoadPpfModels(const std::filesystem::path& folder,
                                                       const std::vector<std::string>& use,
                                                       const PpfTableParameters& parameters);

}  // namespace vantage
