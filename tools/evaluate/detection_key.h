#pragma once

#include <string>

#include "perception/model/object_model.h"
#include "tools/evaluate/simulated_sequence.h"

namespace vantage {

/// To be raised whenever the simulation, the sensor or the estimator gives other detections for the
/// same parameters: detections kept from before are then made again.
inline constexpr int kDetectionsVersion = 2;

/// All that sequences of one model and kind depend on, in lines of text that a person can read:
/// version, what the model's files hold, seed, views, camera, sensor and estimator. Equal texts
/// mean equal sequences.
std::string DetectionKey(const ObjectModel& model,
                         SequenceKind kind,
                         const SimulationParameters& parameters);

}  // namespace vantage
