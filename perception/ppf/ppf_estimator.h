#pragma once

#include <memory>
#include <vector>

#include "common/result.h"
#include "perception/estimator/pose_estimator.h"
#include "perception/model/object_model.h"
#include "perception/ppf/ppf_table.h"
#include "perception/ppf/ppf_voting.h"

namespace vantage {

struct PpfEstimatorParameters {
  PpfTableParameters table;
  PpfVotingParameters voting;
  PoseEstimatorParameters estimation;
  Result<void> Validate() const;
};

/// A model beside its matching table.
struct PpfModel {
  ObjectModel object;
  PpfTable table;
};

/// An estimator that votes with point pair features (paper section 3.1).
/// Errors: parameters, a model of a size that no object has.
Result<std::unique_ptr<PoseEstimator>> CreatePpfEstimator(std::vector<PpfModel> models,
                                                          const PpfEstimatorParameters& parameters);
/// Trains the models' tables first. Errors: also a model that can't be trained.
Result<std::unique_ptr<PoseEstimator>> CreatePpfEstimator(std::vector<ObjectModel> models,
                                                          const PpfEstimatorParameters& parameters);

}  // namespace vantage
