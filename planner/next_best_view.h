#pragma once

#include <Eigen/Core>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "common/so3.h"
#include "fusion/object_tracker.h"

namespace vantage {

/// What a criterion may judge views by.
struct PlanningState {
  std::span<const Pose> candidates;                  ///< T_world_camera each
  std::span<const Pose> visited;                     ///< T_world_camera of all viewpoints so far
  std::span<const ObjectEstimate> objects;           ///< with their histograms
  Eigen::Vector3d target = Eigen::Vector3d::Zero();  ///< m, world; what the candidates look at
};

/// A next-best-view criterion (paper 6.4): a gain for every candidate, the more the better.
struct ViewCriterion {
  std::string name;
  std::function<std::vector<double>(const PlanningState&)> gains;
};

/// Gain: angle (rad), seen from the target, between the candidate and the visited view nearest to
/// it; pi while none was visited. Needs no model of the objects: views far from each other have
/// the least in common.
ViewCriterion FarthestView();

/// What became of a candidate so far. Neither kind is selected (again).
struct CandidateStatus {
  bool visited = false;
  std::string refusal;  ///< why the robot can't go there; empty as far as known it can
};

/// A candidate, judged.
struct JudgedView {
  Pose T_world_camera = Pose::Identity();
  double gain = 0.0;      ///< in the criterion's unit
  double cost = 0.0;      ///< m, straight line from where the camera is
  bool reachable = true;  ///< False when the robot refused it
  std::string reason;     ///< why it can't be selected; empty when it can
};

/// The decision. `selected` is -1 when no view is left.
struct NextView {
  std::string criterion;
  std::vector<JudgedView> candidates;
  int selected = -1;
  std::string reason;
};

/// Selects the candidate with the largest gain; of equal ones (1e-9) the nearest, then the first.
/// @param status of each candidate.
/// @param T_world_camera where the camera is.
NextView SelectNextView(const PlanningState& state,
                        const ViewCriterion& criterion,
                        std::span<const CandidateStatus> status,
                        const Pose& T_world_camera);

/// Index of the candidate that a view is nearest to, by angle seen from the target, then by
/// distance; -1 without candidates.
int NearestCandidate(std::span<const Pose> candidates,
                     const Pose& T_world_camera,
                     const Eigen::Vector3d& target);

}  // namespace vantage
