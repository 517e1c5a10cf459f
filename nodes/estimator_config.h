#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/result.h"
#include "nodes/config_reader.h"
#include "nodes/models_config.h"
#include "perception/estimator/pose_estimator.h"
#include "perception/ppf/ppf_estimator.h"

namespace vantage {

/// What every estimator's process reads: [models] and, of its own table, all but its method.
struct EstimatorConfig {
  std::string camera;           ///< the <NAME> of the channels
  uint64_t seed = 1;            ///< of all random choices
  double rest_window_s = 0.15;  ///< s before and after an image in which the camera rests
  ModelsConfig models;
};

/// Reads what is common to estimators from the table `own`, and [models], [segmentation],
/// [verification] and [refinement]. `camera` may be left out when there is one table
/// [camera.<NAME>]. Errors are kept by `config`.
void ReadEstimatorConfig(ConfigReader& config,
                         ConfigReader::Table& own,
                         EstimatorConfig* result,
                         PoseEstimatorParameters* parameters);

/// The models in use. Errors: FindModels(); a model that can't be read.
Result<std::vector<ObjectModel>> LoadModels(const ModelsConfig& config);

/// The models in use with their point pair tables: those in the folder if they fit, trained
/// otherwise. Errors: FindModels(); a model that can't be read.
Result<std::vector<PpfModel>> LoadPpfModels(const ModelsConfig& config,
                                            const PpfTableParameters& parameters);

}  // namespace vantage
