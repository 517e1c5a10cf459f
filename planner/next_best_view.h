#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/so3.h"
#include "planner/view_criterion.h"

namespace vantage {

/// What became of a candidate so far. Neither kind is selected (again).
struct CandidateStatus {
  bool visited = false;
  std::string refusal;  ///< why the robot can't go there; empty as far as known it can
};

/// A candidate, judged.
struct JudgedView {
  /// Why it can't be selected, if it can't.
  enum class Rejection { kNone, kVisited, kOutOfReach, kRefused, kHidden };

  Pose T_world_camera = Pose::Identity();
  double gain = 0.0;      ///< in the criterion's unit
  double cost = 0.0;      ///< m, straight line from where the camera is
  bool reachable = true;  ///< False when out of reach, in a keep-out volume or refused by the robot
  Rejection rejection = Rejection::kNone;
  std::string reason;  ///< of the rejection, in words; empty when there is none
};

/// The decision. `selected` is -1 when no view is left.
struct NextView {
  std::string criterion;
  std::vector<JudgedView> candidates;
  int selected = -1;
  std::string reason;
  /// nat, the most that a view left is expected to tell about objects with a confusion model; none:
  /// the criterion's gains are not in nat.
  std::optional<double> information;
};

/// What a decision rests on beside the criterion.
struct ViewChoice {
  std::span<const CandidateStatus> status;  ///< of each candidate
  /// Why each can't be reached, empty when it can; no texts at all: all can.
  std::span<const std::string> out_of_reach = {};
  Pose T_world_camera = Pose::Identity();  ///< where the camera is
  double travel_weight = 0.0;  ///< nat/m; what a meter of way must bring, of criteria in nat
};

/// Selects the candidate with the largest utility, gain less travel weight times cost; of equal
/// ones (1e-9) the nearest, then the first. Candidates that all objects are hidden from are left
/// out.
NextView SelectNextView(const PlanningState& state,
                        const ViewCriterion& criterion,
                        const ViewChoice& choice);

/// Index of the candidate that a view is nearest to, by angle seen from the target, then by
/// distance; -1 without candidates.
int NearestCandidate(std::span<const Pose> candidates,
                     const Pose& T_world_camera,
                     const Eigen::Vector3d& target);

}  // namespace vantage
