#pragma once

#include <string>
#include <vector>

#include "common/detection.h"
#include "common/so3.h"

namespace vantage {

/// What the estimator made of one simulated view.
struct DetectedView {
  Pose T_world_camera = Pose::Identity();
  /// Hypotheses of the object's model, best first; empty when it was not found.
  std::vector<Detection> detections;
};

/// The views of one object from several places, in their order, and the truth.
struct DetectionSequence {
  std::string model_id;
  int index = 0;  ///< of the sequences of this model
  Pose T_world_object = Pose::Identity();
  std::vector<DetectedView> views;
};

}  // namespace vantage
