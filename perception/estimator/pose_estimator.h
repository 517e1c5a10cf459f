#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/camera_model.h"
#include "common/depth_image.h"
#include "common/detection.h"
#include "common/result.h"
#include "common/rng.h"
#include "perception/estimator/known_model.h"
#include "perception/estimator/pose_proposer.h"
#include "perception/estimator/stage_times.h"
#include "perception/refinement/refinement.h"
#include "perception/segmentation/normals.h"
#include "perception/segmentation/segmentation.h"
#include "perception/segmentation/surface_sampler.h"
#include "perception/verification/observed_image.h"
#include "perception/verification/verification.h"

namespace vantage {

/// Of all estimators, whatever proposes their poses.
struct PoseEstimatorParameters {
  SegmentationParameters segmentation;
  NormalParameters normals;
  VerificationParameters verification;
  RefinementParameters refinement;
  int coarse_hypotheses = 4;       ///< of each model, kept after the refinement on points
  int fine_hypotheses = 4;         ///< of each cluster, refined on pixels
  int max_scene_points = 1000;     ///< of a cluster; more are thinned
  int hypotheses_per_cluster = 1;  ///< published, best first
  Result<void> Validate() const;
};

/// Poses of known objects in one depth image (paper section 3): segments, has poses proposed,
/// refines them by ICP and verifies them by rendering.
class PoseEstimator {
 public:
  /// @param proposer of the same models, by their index.
  /// Errors: parameters.
  static Result<std::unique_ptr<PoseEstimator>> Create(std::vector<KnownModel> models,
                                                       std::unique_ptr<PoseProposer> proposer,
                                                       const PoseEstimatorParameters& parameters);

  /// Another that estimates the same, for another thread.
  [[nodiscard]] std::unique_ptr<PoseEstimator> Clone() const;

  struct Output {
    int num_clusters = 0;               ///< that were tried
    std::vector<Detection> detections;  ///< by cluster; of one cluster the best first
  };
  /// Empty when nothing was found. The same for equal input and state of `rng`, whatever was
  /// estimated before. Valid until the next call.
  /// @param depth of the camera's width and height.
  /// @param times may be null.
  const Output& Estimate(const DepthImage& depth,
                         const CameraModel& camera,
                         Rng& rng,
                         StageTimes* times = nullptr);

 private:
  struct Hypothesis {
    size_t model = 0;
    Pose T_camera_object = Pose::Identity();
    Verification verification = {};
    Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  };
  using Hypotheses = std::vector<Hypothesis>;

  PoseEstimator(std::vector<KnownModel> models,
                std::unique_ptr<PoseProposer> proposer,
                const PoseEstimatorParameters& parameters);

  void Propose(size_t cluster,
               size_t model,
               std::span<const SurfacePoint> points,
               Rng& rng,
               StageTimes* times);
  void Explain(size_t cluster, Rng& rng, StageTimes* times);
  enum class Effort { kCoarse, kFine, kLast };
  void Verify(
      size_t cluster, Effort effort, size_t first, StageTimes* times, Hypotheses* hypotheses);
  [[nodiscard]] int Step(Effort effort, size_t cluster) const;
  double PixelCost(size_t cluster, int step);
  void Refine(Effort effort, StageTimes* times, Hypotheses* hypotheses);
  void Settle(size_t cluster, StageTimes* times, Hypotheses* hypotheses);
  void KeepDistinct(size_t count, double angle, Hypotheses* hypotheses);
  void Report(size_t cluster);
  [[nodiscard]] bool IsExplained(const Cluster& cluster);

  std::vector<KnownModel> models_;
  std::unique_ptr<PoseProposer> proposer_;
  PoseEstimatorParameters parameters_;
  double finest_spacing_ = 0.0;  // m, of the scene points that the proposer wants.

  // Reused.
  Segmenter segmenter_;
  SurfaceSampler sampler_;
  ObservedImage image_;
  ScenePoints scene_points_;  // scene_, for the refinement.
  Refiner refiner_;
  ModelView view_;
  std::vector<SurfacePoint> scene_;
  Hypotheses proposed_;   // Of one cluster and model.
  Hypotheses explained_;  // Of one cluster.
  Hypotheses distinct_;
  std::vector<uint8_t> is_explained_;   // By pixel.
  std::optional<Hypothesis> unmarked_;  // Found, but not in is_explained_ yet.
  Output output_;
};

}  // namespace vantage
