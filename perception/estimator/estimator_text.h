#pragma once

#include <string>

#include "common/parameter_text.h"
#include "perception/ppf/ppf_estimator.h"
#include "perception/shot/shot_estimator.h"

namespace vantage {

/// To be raised whenever the simulation, the sensor or an estimator gives other detections for the
/// same parameters: what was kept from before is then made again.
inline constexpr int kDetectionsVersion = 2;

/// Adds lines of all parameters.
void AddEstimator(const PpfEstimatorParameters& parameters, ParameterText* text);
void AddEstimator(const ShotEstimatorParameters& parameters, ParameterText* text);

/// The version and all parameters: what an estimator finds depends on them and on its models.
std::string EstimatorText(const PpfEstimatorParameters& parameters);
std::string EstimatorText(const ShotEstimatorParameters& parameters);

}  // namespace vantage
