#pragma once

#include "common/result.h"
#include "nodes/config_reader.h"
#include "nodes/estimator_config.h"
#include "perception/ppf/ppf_estimator.h"

namespace vantage {

/// What [ppf], [models], [segmentation], [verification] and [refinement] say.
struct PpfConfig : EstimatorConfig {
  PpfEstimatorParameters estimator;
};

/// Reads the tables; all other processes' tables are left alone.
/// Errors: the first of the whole file, also of keys that nobody knows.
Result<PpfConfig> ReadPpfConfig(ConfigReader& config);

/// The estimator's parameters alone. Errors are kept by `config`.
PpfEstimatorParameters ReadPpfParameters(ConfigReader& config);

}  // namespace vantage
