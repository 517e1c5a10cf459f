#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "common/camera_model.h"
#include "common/depth_image.h"
#include "common/detection.h"
#include "common/result.h"
#include "common/rng.h"
#include "perception/model/object_model.h"
#include "perception/ppf/ppf_table.h"
#include "perception/ppf/ppf_voting.h"
#include "perception/refinement/refinement.h"
#include "perception/segmentation/normals.h"
#include "perception/segmentation/segmentation.h"
#include "perception/verification/verification.h"

namespace vantage {

struct PpfEstimatorParameters {
  PpfTableParameters table;
  SegmentationParameters segmentation;
  NormalParameters normals;
  PpfVotingParameters voting;
  VerificationParameters verification;
  RefinementParameters refinement;
  int coarse_hypotheses = 4;       ///< of each model, refined on samples
  int fine_hypotheses = 4;         ///< of each cluster, refined on pixels
  int max_scene_points = 1000;     ///< of a cluster; more are thinned
  int hypotheses_per_cluster = 1;  ///< published, best first
  Result<void> Validate() const;
};

/// Seconds that the stages of one call took, by the caller's clock.
struct StageTimes {
  std::function<double()> clock;  ///< s
  double segmentation = 0.0;
  double normals = 0.0;
  double voting = 0.0;
  double verification = 0.0;
  double refinement = 0.0;
};

/// Poses of known objects in one depth image (paper section 3.1): segments, votes with point pair
/// features, verifies by rendering, refines by ICP.
class PpfEstimator {
 public:
  struct Model {
    ObjectModel object;
    PpfTable table;
  };

  /// Trains the models' tables. Errors: parameters, a model that can't be trained.
  static Result<std::unique_ptr<PpfEstimator>> Create(std::vector<ObjectModel> models,
                                                      const PpfEstimatorParameters& parameters);
  /// With tables that exist. Errors: parameters.
  static Result<std::unique_ptr<PpfEstimator>> Create(std::vector<Model> models,
                                                      const PpfEstimatorParameters& parameters);

  struct Output {
    int num_clusters = 0;               ///< that were tried
    std::vector<Detection> detections;  ///< by cluster; of one cluster the best first
  };
  /// Empty when nothing was found. The same for equal input and state of `rng`.
  /// @param depth of the camera's width and height.
  /// @param times may be null.
  Output Estimate(const DepthImage& depth,
                  const CameraModel& camera,
                  Rng& rng,
                  StageTimes* times = nullptr);

 private:
  struct Hypothesis {
    size_t model = 0;
    bool is_final = false;  // Drawn with the whole mesh.
    Pose T_camera_object = Pose::Identity();
    Verification verification;
  };

  PpfEstimator(std::vector<Model> models, const PpfEstimatorParameters& parameters);
  // A model beside what hypotheses of it need.
  struct Prepared {
    Model model;
    NearestGrid grid;                // For coarse refinement.
    DrawableMesh mesh;               // Whole.
    DrawableMesh quick_mesh;         // For all but the last refinement.
    double radius;                   // m, about the center
    std::vector<Pose> alternatives;  // Self alignments.
  };
  static Prepared Prepare(Model model);
  static ModelShape Shape(const Prepared& prepared, const DrawableMesh& mesh);

  void VerifyAndSort(const SegmentedImage& image,
                     size_t cluster,
                     int step,
                     StageTimes* times,
                     std::vector<Hypothesis>* hypotheses);
  std::vector<Hypothesis> Propose(
      const SegmentedImage& image, size_t cluster, size_t model, Rng& rng, StageTimes* times);
  std::vector<Hypothesis> Explain(const SegmentedImage& image,
                                  size_t cluster,
                                  Rng& rng,
                                  StageTimes* times);

  PpfEstimatorParameters parameters_;
  std::vector<Prepared> models_;
  ModelView view_;  // Reused.
};

}  // namespace vantage
