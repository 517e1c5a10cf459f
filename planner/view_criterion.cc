#include "planner/view_criterion.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace vantage {

double PlanningState::Unhidden(size_t candidate, size_t object) const {
  return visibility.empty() ? 1.0 : UnhiddenFactor(visibility[candidate * objects.size() + object]);
}

double AngleFromTarget(const Pose& a, const Pose& b, const Eigen::Vector3d& target) {
  const Eigen::Vector3d to_a = a.translation() - target;
  const Eigen::Vector3d to_b = b.translation() - target;
  return std::atan2(to_a.cross(to_b).norm(), to_a.dot(to_b));
}

std::vector<double> AnglesToNearestVisited(const PlanningState& state) {
  std::vector<double> angles;
  for (const Pose& candidate : state.candidates) {
    double smallest = std::numbers::pi;
    for (const Pose& visited : state.visited) {
      smallest = std::min(smallest, AngleFromTarget(candidate, visited, state.target));
    }
    angles.push_back(smallest);
  }
  return angles;
}

double AccuracyGain(size_t num_visited, double angle) {
  const double n = std::max(1.0, static_cast<double>(num_visited));
  return 1.5 * std::log1p(1.0 / n) * angle / std::numbers::pi;
}

}  // namespace vantage
