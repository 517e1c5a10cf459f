#pragma once

#include <Eigen/Core>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "common/so3.h"
#include "planner/occlusion.h"
#include "planner/planned_object.h"

namespace vantage {

/// What a criterion may judge views by.
struct PlanningState {
  std::span<const Pose> candidates;                  ///< T_world_camera each
  std::span<const Pose> visited;                     ///< T_world_camera of all viewpoints so far
  std::span<const PlannedObject> objects;            ///< empty: none is known
  Eigen::Vector3d target = Eigen::Vector3d::Zero();  ///< m, world; what the candidates look at
  /// Of every object from every candidate, candidate by candidate; empty: all can be seen.
  std::span<const Visibility> visibility = {};

  /// Probability factor that an object is found in spite of what hides it; 1 when that is unknown.
  [[nodiscard]] double Unhidden(size_t candidate, size_t object) const;
};

/// What a criterion promises.
struct ViewGains {
  std::vector<double> total;      ///< by candidate, the more the better
  std::vector<double> by_object;  ///< its parts, candidate by candidate; empty: not by object
};

inline constexpr const char* kNat = "nat";

/// A next-best-view criterion (paper 6.4).
struct ViewCriterion {
  std::string name;
  std::string unit;  ///< of its gains; those in kNat can be weighed against travel
  std::function<ViewGains(const PlanningState&)> gains;
};

/// Angle between two camera positions seen from the target, rad.
double AngleFromTarget(const Pose& a, const Pose& b, const Eigen::Vector3d& target);

/// Angle (rad), seen from the target, between each candidate and the visited view nearest to it; pi
/// while none was visited.
std::vector<double> AnglesToNearestVisited(const PlanningState& state);

/// What a further look at an object brings whatever its orientation, nat: the errors of n views
/// average out like 1/n, so that in three dimensions one more brings 3/2 ln(1 + 1/n), as far as its
/// errors are not those of a view before: the share angle / pi.
/// @param angle rad, to the nearest visited view.
double AccuracyGain(size_t num_visited, double angle);

}  // namespace vantage
