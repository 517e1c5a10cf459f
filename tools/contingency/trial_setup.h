#pragma once

#include <cstdint>
#include <string>

#include "common/result.h"
#include "fusion/confusion/contingency_table.h"
#include "perception/model/object_model.h"
#include "tools/contingency/measure_table.h"
#include "tools/contingency/trial_simulator.h"

namespace vantage {

/// A model's folder, or the name of a generated object. Errors: neither; as LoadObjectModel; a
/// sphere, of which all orientations look alike.
Result<ObjectModel> FindTrialModel(const std::string& folder_or_name);

/// True when the surface is everywhere as far from the center, to 1 % of the diameter.
bool IsSphere(const ObjectModel& model);

/// How trials look at objects.
/// @param config_file what the processes read: the estimator's own tables and [sim.sensor] where
/// there is one; empty: all defaults.
/// Errors: the file; an estimator of no such name.
Result<TrialParameters> ReadTrialParameters(const std::string& estimator,
                                            const std::string& config_file);

/// Key of a table of a model measured like that.
ContingencyKey MakeKey(const ObjectModel& model,
                       const TrialParameters& parameters,
                       const TrialPlan& plan,
                       int num_directions,
                       int rows_k);

/// Simulators of their own for every thread. The model must outlive the detectors.
TrialDetectorFactory SimulatedDetectors(const ObjectModel& model,
                                        const TrialParameters& parameters);

}  // namespace vantage
