#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/camera_model.h"
#include "common/depth_image.h"
#include "common/detection.h"
#include "common/result.h"
#include "common/rng.h"
#include "perception/model/object_model.h"
#include "perception/segmentation/segmentation.h"

namespace vantage {

/// Seconds of one call by its stages.
struct StageSeconds {
  double segmentation = 0.0;
  double normals = 0.0;
  double proposal = 0.0;  ///< voting, or whatever else the estimator finds its hypotheses by
  double verification = 0.0;
  double refinement = 0.0;
};

/// What an estimator makes of an image.
struct DatasetEstimate {
  std::vector<Detection> detections;
  int num_clusters = 0;
  double seconds = 0.0;
  StageSeconds stages;
};

/// An estimator of some models, ready to be called.
using DatasetEstimator =
    std::function<DatasetEstimate(const DepthImage&, const CameraModel&, Rng&)>;

/// Names for MakeEstimator(): the one, or every one for "all". Errors: no such estimator; the
/// message lists them.
Result<std::vector<std::string>> FindEstimators(const std::string& name);

/// @param name one of FindEstimators(). Errors: models that the estimator refuses.
Result<DatasetEstimator> MakeEstimator(const std::string& name,
                                       std::vector<ObjectModel> models,
                                       SegmentationParameters::Support support);

}  // namespace vantage
