#include "planner/next_best_view.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/check.h"
#include "common/format.h"

namespace vantage {
namespace {

// Angle between two camera positions seen from the target, rad.
double AngleFromTarget(const Pose& a, const Pose& b, const Eigen::Vector3d& target) {
  const Eigen::Vector3d to_a = a.translation() - target;
  const Eigen::Vector3d to_b = b.translation() - target;
  return std::atan2(to_a.cross(to_b).norm(), to_a.dot(to_b));
}

std::vector<double> AnglesToNearestVisited(const PlanningState& state) {
  std::vector<double> gains;
  for (const Pose& candidate : state.candidates) {
    double smallest = std::numbers::pi;
    for (const Pose& visited : state.visited) {
      smallest = std::min(smallest, AngleFromTarget(candidate, visited, state.target));
    }
    gains.push_back(smallest);
  }
  return gains;
}

}  // namespace

ViewCriterion FarthestView() { return {"farthest", AnglesToNearestVisited}; }

NextView SelectNextView(const PlanningState& state,
                        const ViewCriterion& criterion,
                        std::span<const CandidateStatus> status,
                        const Pose& T_world_camera) {
  const std::vector<double> gains = criterion.gains(state);
  const size_t count = state.candidates.size();
  VANTAGE_CHECK(
      gains.size() == count && status.size() == count,
      Format("%zu candidates, %zu gains, %zu states", count, gains.size(), status.size()));
  NextView view;
  view.criterion = criterion.name;
  for (size_t i = 0; i < count; ++i) {
    JudgedView judged;
    judged.T_world_camera = state.candidates[i];
    judged.gain = gains[i];
    judged.cost = (state.candidates[i].translation() - T_world_camera.translation()).norm();
    judged.reachable = status[i].refusal.empty();
    judged.reason = status[i].visited ? "visited" : status[i].refusal;
    view.candidates.push_back(judged);
    if (!judged.reason.empty()) continue;
    if (view.selected >= 0) {
      const JudgedView& best = view.candidates[static_cast<size_t>(view.selected)];
      constexpr double kEqual = 1e-9;
      const double more = judged.gain - best.gain;
      if (more < -kEqual || (more <= kEqual && judged.cost >= best.cost - kEqual)) continue;
    }
    view.selected = static_cast<int>(i);
  }
  if (view.selected < 0) {
    view.reason = Format("none of the %zu views is left", count);
  } else {
    const JudgedView& best = view.candidates[static_cast<size_t>(view.selected)];
    view.reason = Format("view %d has the largest gain by criterion \"%s\", %.4g, at %.2f m",
                         view.selected,
                         criterion.name.c_str(),
                         best.gain,
                         best.cost);
  }
  return view;
}

int NearestCandidate(std::span<const Pose> candidates,
                     const Pose& T_world_camera,
                     const Eigen::Vector3d& target) {
  int nearest = -1;
  double smallest_angle = std::numeric_limits<double>::infinity();
  double smallest_distance = smallest_angle;
  for (size_t i = 0; i < candidates.size(); ++i) {
    const double angle = AngleFromTarget(candidates[i], T_world_camera, target);
    const double distance = (candidates[i].translation() - T_world_camera.translation()).norm();
    constexpr double kEqual = 1e-9;
    if (angle > smallest_angle + kEqual) continue;
    if (angle > smallest_angle - kEqual && distance >= smallest_distance) continue;
    smallest_angle = angle;
    smallest_distance = distance;
    nearest = static_cast<int>(i);
  }
  return nearest;
}

}  // namespace vantage
