#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/result.h"
#include "nodes/config_reader.h"
#include "nodes/models_config.h"
#include "perception/ppf/ppf_estimator.h"

namespace vantage {

/// What [ppf], [models], [segmentation], [verification] and [refinement] say.
struct PpfConfig {
  std::string camera;           ///< the <NAME> of the channels
  uint64_t seed = 1;            ///< of all random choices
  double rest_window_s = 0.15;  ///< s before and after an image in which the camera rests
  ModelsConfig models;
  PpfEstimatorParameters estimator;
};

/// Reads the tables; all other processes' tables are left alone. `camera` may be left out when
/// there is one table [camera.<NAME>].
/// Errors: the first of the whole file, also of keys that nobody knows.
Result<PpfConfig> ReadPpfConfig(ConfigReader& config);

/// The models in use with their matching tables: those in the folder if they fit, trained
/// otherwise. Errors: FindModels(); a model that can't be read.
Result<std::vector<PpfEstimator::Model>> LoadPpfModels(const ModelsConfig& config,
                                                       const PpfTableParameters& parameters);

}  // namespace vantage
