#pragma once

#include <memory>
#include <vector>

#include "common/result.h"
#include "perception/estimator/pose_estimator.h"
#include "perception/model/object_model.h"
#include "perception/shot/shot_parameters.h"

namespace vantage {

struct ShotEstimatorParameters {
  ShotParameters shot;
  PoseEstimatorParameters estimation;
  Result<void> Validate() const;
};

/// An estimator that matches SHOT descriptors and finds their consensus by RANSAC (paper section
/// 3.2). Errors: parameters, a model that can't be trained or of a size that no object has.
Result<std::unique_ptr<PoseEstimator>> CreateShotEstimator(
    std::vector<ObjectModel> models, const ShotEstimatorParameters& parameters);

}  // namespace vantage
