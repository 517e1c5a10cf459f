#pragma once

#include "common/result.h"
#include "nodes/config_reader.h"
#include "nodes/estimator_config.h"
#include "perception/shot/shot_estimator.h"

namespace vantage {

/// What [shot], [models], [segmentation], [verification] and [refinement] say.
struct ShotConfig : EstimatorConfig {
  ShotEstimatorParameters estimator;
};

/// Reads the tables; all other processes' tables are left alone.
/// Errors: the first of the whole file, also of keys that nobody knows.
Result<ShotConfig> ReadShotConfig(ConfigReader& config);

/// The estimator's parameters alone. Errors are kept by `config`.
ShotEstimatorParameters ReadShotParameters(ConfigReader& config);

}  // namespace vantage
