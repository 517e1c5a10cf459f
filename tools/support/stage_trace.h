#pragma once

#include <cstdint>
#include <vector>

#include "common/detection.h"
#include "common/result.h"
#include "perception/estimator/known_model.h"
#include "perception/ppf/ppf_estimator.h"
#include "perception/segmentation/segmentation.h"
#include "perception/verification/verification.h"
#include "tools/support/stage_image.h"

namespace vantage {

/// What became of one model in one cluster.
struct ModelTrace {
  enum class Outcome {
    kAccepted,
    kNoProposals,
    kLowScore,     ///< below min_score after the last verification
    kHidden,       ///< Too little of the model is measured.
    kOtherBetter,  ///< a pose that passes, but another explains the cluster better
  };
  size_t model = 0;                  ///< index into StageTrace::models
  std::vector<SurfacePoint> points;  ///< of the scene, as the proposer got them
  std::vector<Pose> proposals;       ///< T_camera_object, as proposed: most promising first
  double coarse_score = 0.0;         ///< [0, 1], best after the refinement on points
  Pose T_best = Pose::Identity();    ///< T_camera_object, detected or else the best after all
  Verification verification;         ///< of T_best
  Outcome outcome = Outcome::kNoProposals;
};

struct ClusterTrace {
  size_t num_points = 0;           ///< surface points, as dense as any model wants them
  std::vector<ModelTrace> models;  ///< that poses were sought of; empty: it was not tried
};

/// What each stage of the estimator makes of an image.
struct StageTrace {
  std::vector<KnownModel> models;
  Segmentation segmentation;
  std::vector<ClusterTrace> clusters;  ///< as Segmentation::clusters
  std::vector<Detection> detections;   ///< as the estimator publishes them
};

/// Runs the estimator on an image, as vantage-ppf does, and its last stages once more for models
/// that it did not report.
/// Errors: as CreatePpfEstimator.
Result<StageTrace> TraceStages(std::vector<PpfModel> models,
                               const PpfEstimatorParameters& parameters,
                               const StageImage& image,
                               uint64_t seed);

/// The model of a cluster that was accepted, else the one of the highest score; null when none has
/// a pose.
const ModelTrace* BestModel(const ClusterTrace& cluster);

}  // namespace vantage
