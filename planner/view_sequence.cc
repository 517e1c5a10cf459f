#include "planner/view_sequence.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/format.h"
#include "fusion/state_text.h"

namespace vantage {
namespace {

std::vector<std::string> FindRefusals(const ReachabilityParameters& reach,
                                      const std::vector<Pose>& candidates) {
  std::vector<std::string> refusals;
  for (const Pose& candidate : candidates) refusals.push_back(ReachRefusal(reach, candidate));
  return refusals;
}

}  // namespace

Result<void> ViewSequenceParameters::Validate() const {
  if (frames_per_view < 1 || max_views < 1) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("frames_per_view = %d and max_views = %d, expected 1 or more",
                        frames_per_view,
                        max_views)};
  }
  if (!(travel_weight >= 0.0 && std::isfinite(travel_weight))) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("travel_weight = %g nat/m, expected 0 or more", travel_weight)};
  }
  if (Result<void> valid = viewpoint.Validate(); !valid) return valid;
  if (Result<void> valid = reach.Validate(); !valid) return valid;
  if (Result<void> valid = occlusion.Validate(); !valid) return valid;
  if (Result<void> valid = stop.Validate(); !valid) return valid;
  return candidates.Validate();
}

ViewSequence::ViewSequence(const ViewSequenceParameters& parameters, ViewCriterion criterion)
    : parameters_(parameters),
      criterion_(std::move(criterion)),
      candidates_(MakeViewCandidates(parameters.candidates)),
      out_of_reach_(FindRefusals(parameters.reach, candidates_)),
      occlusion_(parameters.occlusion) {
  state_.status.resize(candidates_.size());
}

bool ViewSequence::OnSet(int64_t utime,
                         const Pose& T_world_camera,
                         int viewpoint,
                         const std::vector<Viewpoint>& viewpoints,
                         std::span<const PlannedObject> objects) {
  const Viewpoint& current = viewpoints[static_cast<size_t>(viewpoint)];
  // A robot that is not exact may end where it was before: the selected view is done then, too.
  if (IsAtSelected(utime, T_world_camera)) ++num_sets_at_selected_;
  const bool is_selected_done = num_sets_at_selected_ >= parameters_.frames_per_view &&
                                current.num_sets >= parameters_.frames_per_view;
  const bool is_due = current.num_sets == parameters_.frames_per_view || is_selected_done;
  if (!is_due || state_.finished) return false;
  state_.T_world_camera = current.T_world_camera;
  if (state_.selected >= 0 && (is_selected_done || arrival_utime_ >= 0)) {
    state_.status[static_cast<size_t>(state_.selected)].visited = true;
  }
  Decide(
      state_.decision < 0 ? std::max(utime, int64_t{0}) : state_.decision + 1, viewpoints, objects);
  return true;
}

// As the robot says, or where it does not, when no other candidate is nearer.
bool ViewSequence::IsAtSelected(int64_t utime, const Pose& T_world_camera) {
  if (state_.selected < 0) return false;
  if (arrival_utime_ >= 0) return utime >= arrival_utime_;
  return NearestCandidate(candidates_, T_world_camera, parameters_.candidates.target) ==
         state_.selected;
}

bool ViewSequence::OnRefused(int64_t decision,
                             const std::string& reason,
                             const std::vector<Viewpoint>& viewpoints,
                             std::span<const PlannedObject> objects) {
  if (decision != this->decision() || state_.selected < 0) return false;
  state_.status[static_cast<size_t>(state_.selected)].refusal =
      reason.empty() ? "refused by the robot" : reason;
  Decide(state_.decision + 1, viewpoints, objects);
  return true;
}

void ViewSequence::OnArrived(int64_t decision, int64_t utime) {
  if (decision != this->decision() || state_.selected < 0 || arrival_utime_ >= 0) return;
  arrival_utime_ = utime;
  num_sets_at_selected_ = 0;
}

// The candidate nearest to each viewpoint, and all that would be the same viewpoint.
void ViewSequence::MarkVisited(const std::vector<Viewpoint>& viewpoints) {
  for (const Viewpoint& viewpoint : viewpoints) {
    const int nearest =
        NearestCandidate(candidates_, viewpoint.T_world_camera, parameters_.candidates.target);
    if (nearest >= 0) state_.status[static_cast<size_t>(nearest)].visited = true;
  }
  for (size_t i = 0; i < candidates_.size(); ++i) {
    if (FindViewpoint(viewpoints, candidates_[i], parameters_.viewpoint) >= 0) {
      state_.status[i].visited = true;
    }
  }
}

NextView ViewSequence::Select(const std::vector<Viewpoint>& viewpoints,
                              std::span<const PlannedObject> objects) {
  std::vector<Pose> visited;
  for (const Viewpoint& viewpoint : viewpoints) visited.push_back(viewpoint.T_world_camera);
  const PlanningState state{candidates_,
                            visited,
                            objects,
                            parameters_.candidates.target,
                            occlusion_.Find(candidates_, objects)};
  return SelectNextView(
      state,
      criterion_,
      {state_.status, out_of_reach_, state_.T_world_camera, parameters_.travel_weight});
}

void ViewSequence::Decide(int64_t number,
                          const std::vector<Viewpoint>& viewpoints,
                          std::span<const PlannedObject> objects) {
  MarkVisited(viewpoints);
  next_view_ = Select(viewpoints, objects);
  std::string done =
      StopReason(parameters_.stop, objects, next_view_.information, viewpoints.size());
  if (done.empty() && static_cast<int>(viewpoints.size()) >= parameters_.max_views) {
    done = Format("%zu views were taken, which is max_views", viewpoints.size());
  }
  if (!done.empty()) {
    next_view_.selected = -1;
    next_view_.reason = done;
  }
  state_.finished = state_.finished || next_view_.selected < 0;
  state_.decision = number;
  state_.selected = next_view_.selected;
  state_.reason = next_view_.reason;
  arrival_utime_ = -1;
  num_sets_at_selected_ = 0;
}

Result<void> ViewSequence::Restore(const ViewSequenceState& state,
                                   const std::vector<Viewpoint>& viewpoints,
                                   std::span<const PlannedObject> objects) {
  if (state.status.size() != candidates_.size()) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("the saved state has %zu view candidates, expected %zu",
                        state.status.size(),
                        candidates_.size())};
  }
  state_ = state;
  arrival_utime_ = -1;
  num_sets_at_selected_ = 0;
  if (state_.decision < 0) return {};
  next_view_ = Select(viewpoints, objects);
  next_view_.selected = state_.selected;
  next_view_.reason = state_.reason;
  return {};
}

std::string FormatViewSequenceState(const ViewSequenceState& state) {
  std::string text = Format("decision %lld %d %d ",
                            static_cast<long long>(state.decision),
                            state.finished ? 1 : 0,
                            state.selected);
  text += FormatName(state.reason) + FormatPose(state.T_world_camera) + "\n";
  text += Format("candidates %zu\n", state.status.size());
  for (const CandidateStatus& status : state.status) {
    text += Format("candidate %d ", status.visited ? 1 : 0) + FormatName(status.refusal) + "\n";
  }
  return text;
}

ViewSequenceState ReadViewSequenceState(StateReader& reader) {
  ViewSequenceState state;
  reader.Keyword("decision");
  // Far from the end of the range, so that counting on can't overflow.
  state.decision = reader.Number<int64_t>(-1, INT64_MAX / 2);
  state.finished = reader.Number<int>(0, 1) == 1;
  state.selected = reader.Number<int>(-1, INT32_MAX);
  state.reason = reader.Name();
  state.T_world_camera = reader.RigidPose();
  reader.Keyword("candidates");
  const size_t num_candidates = reader.Count();
  if (state.selected >= static_cast<int>(num_candidates)) reader.Fail("the selected candidate");
  for (size_t i = 0; i < num_candidates && !reader.failed(); ++i) {
    reader.Keyword("candidate");
    CandidateStatus status;
    status.visited = reader.Number<int>(0, 1) == 1;
    status.refusal = reader.Name();
    state.status.push_back(std::move(status));
  }
  return state;
}

}  // namespace vantage
