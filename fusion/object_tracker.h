#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "common/detection.h"
#include "common/result.h"
#include "fusion/confusion/confusion_model.h"
#include "fusion/confusion/mode_belief.h"
#include "fusion/orientation_filter.h"
#include "fusion/position_filter.h"
#include "fusion/so3_grid.h"
#include "fusion/tracker_state.h"
#include "fusion/viewpoints.h"

namespace vantage {

/// What the tracker needs to know of a model.
struct TrackedModel {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< m, surface centroid, object frame
  double diameter = 0.1;                             ///< m
  /// Orientations that it makes equal are one to the estimate and to convergence.
  SymmetryGroup symmetry = SymmetryGroup::None();
  /// Orientations that it is often found in, each with its equivalents; empty: all are as likely.
  std::vector<LikelyPose> likely_poses = {};
  /// What its estimator takes for what; shared with the planner; null: not measured.
  std::shared_ptr<const ConfusionModel> confusion = nullptr;
};

struct ObjectTrackerParameters {
  OrientationFilterParameters orientation{};
  PositionFilterParameters position{};
  ViewpointParameters viewpoint{};
  /// [0, 1], of the prior of models with likely poses: the share that is even over all
  /// orientations.
  double prior_uniform_share = 0.2;
  double gate = 0.04;             ///< m, a detection's center belongs to an instance this near,
  double gate_fraction = 0.1;     ///< or nearer by this part of the model's diameter
  double overlap_fraction = 0.5;  ///< of the smaller diameter; two models so near can't both be
  int confirm_views = 2;          ///< viewpoints from which an object must be seen to be believed
  int lost_views = 3;             ///< viewpoints without it after which an unconfirmed one is lost

  Result<void> Validate() const;
};

/// What is known of one object; object_estimate_v3_t tells the meaning of each.
struct ObjectEstimate {
  enum class State { kTentative, kConfirmed, kLost };

  int instance_id = 0;
  std::string model_id;
  State state = State::kTentative;
  Pose T_world_object = Pose::Identity();  ///< translation of the model's origin; rotation q_f
  Eigen::Vector3d center_world = Eigen::Vector3d::Zero();       ///< m, of the model's center
  Eigen::Matrix3d center_covariance = Eigen::Matrix3d::Zero();  ///< m^2
  /// Best first, at least one; their weights are shares of the histogram's mass, with a belief
  /// probabilities.
  std::vector<OrientationPeak> peaks;
  /// Best first; empty without a confusion model. Of the viewpoints that it was detected from: from
  /// others it may have been hidden.
  std::vector<OrientationHypothesis> belief;
  double entropy = 0.0;  ///< nat
  bool converged = false;
  double last_change = -1.0;                        ///< rad
  double verification_weight = 0.0;                 ///< sum of w_v over the views
  std::vector<Observation> observations;            ///< one a viewpoint
  const OrientationHistogram* histogram = nullptr;  ///< the tracker's, until its next change
};

/// Fuses the detections of all viewpoints into objects. Detections are associated by model and
/// position; the position is that of the model's center, which a wrong orientation moves least.
class ObjectTracker {
 public:
  /// Makes the prior of each model that has likely poses.
  /// @param grid outlives the tracker. Parameters and likely poses are valid, the weights of no
  /// model's poses all 0.
  ObjectTracker(const So3Grid& grid,
                const ObjectTrackerParameters& parameters,
                std::map<std::string, TrackedModel> models);

  /// What became of one set of detections.
  struct Update {
    bool used = false;     ///< False: sent before, invalid camera pose, one viewpoint too many.
    int viewpoint = -1;    ///< that it is from
    bool changed = false;  ///< An observation or a viewpoint is new.
    int num_invalid = 0;   ///< detections dropped: not finite, no rotation, unknown model, misfit
    int num_beyond = 0;    ///< dropped: a viewpoint or objects beyond the most that are kept
  };

  /// What is kept at most, so that no flood of messages fills the memory: far more than one
  /// scene has.
  static constexpr size_t kMostViewpoints = 10'000;
  static constexpr size_t kMostInstances = 1'000;

  /// Uses one set, also an empty one. Of the hypotheses of one cluster the one with the best
  /// verification score is used; of several frames from one viewpoint the best one stands for it.
  Update Add(const DetectionSet& set);

  /// Objects by instance id, without those that overlap a better supported one of another model
  /// and those that no detection with weight supports.
  [[nodiscard]] std::vector<ObjectEstimate> Estimates() const;

  [[nodiscard]] const TrackerState& state() const { return state_; }
  /// Goes on from a state. Errors: it names a model that is not there, or has a detection that
  /// fits too badly to count with the parameters in use.
  Result<void> Restore(TrackerState state);

 private:
  struct Fused {
    PositionEstimate position;
    OrientationFilter orientation;
    double verification_weight = 0.0;
  };

  [[nodiscard]] bool IsValid(const Detection& detection) const;
  [[nodiscard]] Fused NotFused(const std::string& model_id) const;
  enum class Observed { kChanged, kSame, kBeyond };
  Observed Observe(const std::string& model_id, const Observation& observation);
  [[nodiscard]] int FindInstance(const std::string& model_id, const Eigen::Vector3d& center) const;
  void Fuse(size_t instance);
  [[nodiscard]] ObjectEstimate Estimate(size_t instance) const;
  [[nodiscard]] const TrackedModel& ModelOf(const std::string& id) const { return models_.at(id); }

  const So3Grid* grid_;
  ObjectTrackerParameters parameters_;
  std::map<std::string, TrackedModel> models_;
  std::map<std::string, OrientationKnowledge> knowledge_;  // Of each model.
  TrackerState state_;
  std::vector<Fused> fused_;  // By place in state_.instances.
};

}  // namespace vantage
