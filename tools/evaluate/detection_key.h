#pragma once

#include <string>

#include "perception/model/object_model.h"
#include "tools/evaluate/simulated_sequence.h"

namespace vantage {

/// All that sequences of one model and kind depend on, in lines of text that a person can read:
/// kDetectionsVersion, what the model's files hold, seed, views, camera, sensor and estimator.
/// Equal texts mean equal sequences.
std::string DetectionKey(const ObjectModel& model,
                         SequenceKind kind,
                         const SimulationParameters& parameters);

}  // namespace vantage
