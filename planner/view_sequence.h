#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/result.h"
#include "fusion/viewpoints.h"
#include "planner/next_best_view.h"
#include "planner/occlusion.h"
#include "planner/reachability.h"
#include "planner/stop_rule.h"
#include "planner/view_candidates.h"

namespace vantage {

struct ViewSequenceParameters {
  ViewCandidateParameters candidates{};
  ViewpointParameters viewpoint{};  ///< candidates so near to a viewpoint are visited with it
  ReachabilityParameters reach{};
  OcclusionParameters occlusion{};
  StopParameters stop{};
  double travel_weight = 0.02;  ///< nat/m; what a meter of way must bring
  int frames_per_view = 2;      ///< detection sets to be used from a view before the next
  int max_views = 8;            ///< viewpoints after which it ends

  Result<void> Validate() const;
};

/// What a sequence remembers.
struct ViewSequenceState {
  int64_t decision = -1;  ///< number of the last decision; -1 before the first
  bool finished = false;
  int selected = -1;
  std::string reason;
  Pose T_world_camera = Pose::Identity();  ///< where the camera was at the last decision
  std::vector<CandidateStatus> status;     ///< of each candidate
};

/// Leads from view to view: decides when enough was seen from one, where to go next, and when it is
/// done: nothing left to be found out (StopReason), as many views taken as allowed, or no view
/// left.
class ViewSequence {
 public:
  ViewSequence(const ViewSequenceParameters& parameters, ViewCriterion criterion);

  /// Tells of a detection set that the tracker used.
  /// @param utime us, of its image.
  /// @param T_world_camera where the image was taken.
  /// @param viewpoint index of its viewpoint in `viewpoints`.
  /// @return true when it led to a new decision.
  bool OnSet(int64_t utime,
             const Pose& T_world_camera,
             int viewpoint,
             const std::vector<Viewpoint>& viewpoints,
             std::span<const PlannedObject> objects);
  /// The robot can't go to the view of decision `decision`. Returns true on a new decision.
  bool OnRefused(int64_t decision,
                 const std::string& reason,
                 const std::vector<Viewpoint>& viewpoints,
                 std::span<const PlannedObject> objects);
  /// The robot rests at the view of decision `decision` since `utime` or before.
  void OnArrived(int64_t decision, int64_t utime);

  /// The last decision; nothing is selected before the first.
  [[nodiscard]] const NextView& next_view() const { return next_view_; }
  /// Number of the last decision; -1 before the first. They count up from the utime of the set
  /// that led to the first one, so that a sequence begun anew never repeats a number of an earlier
  /// one, which a robot may still speak of.
  [[nodiscard]] int64_t decision() const { return state_.decision; }
  [[nodiscard]] bool finished() const { return state_.finished; }

  [[nodiscard]] const ViewSequenceState& state() const { return state_; }
  /// Goes on from a state. Errors: it is of another set of candidates.
  Result<void> Restore(const ViewSequenceState& state,
                       const std::vector<Viewpoint>& viewpoints,
                       std::span<const PlannedObject> objects);

 private:
  [[nodiscard]] bool IsAtSelected(int64_t utime, const Pose& T_world_camera);
  void MarkVisited(const std::vector<Viewpoint>& viewpoints);
  void Decide(int64_t number,
              const std::vector<Viewpoint>& viewpoints,
              std::span<const PlannedObject> objects);
  [[nodiscard]] NextView Select(const std::vector<Viewpoint>& viewpoints,
                                std::span<const PlannedObject> objects);

  ViewSequenceParameters parameters_;
  ViewCriterion criterion_;
  std::vector<Pose> candidates_;
  std::vector<std::string> out_of_reach_;  // By candidate, why; empty: it is not.
  OcclusionCache occlusion_;
  ViewSequenceState state_;
  NextView next_view_;
  int64_t arrival_utime_ = -1;  // At the selected view; -1: under way.
  int num_sets_at_selected_ = 0;
};

/// As text; the inverse takes it from the front of a reader's text.
std::string FormatViewSequenceState(const ViewSequenceState& state);
class StateReader;
ViewSequenceState ReadViewSequenceState(StateReader& reader);

}  // namespace vantage
