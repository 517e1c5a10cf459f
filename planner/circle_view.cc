#include "planner/circle_view.h"

#include <cmath>

#include "common/format.h"

namespace vantage {

Result<void> CircleViewParameters::Validate() const {
  constexpr double kPi = std::numbers::pi;
  if (std::abs(elevation) <= 0.5 * kPi && step != 0.0 && std::abs(step) <= kPi) return {};
  return Error{
      ErrorCode::kInvalidArgument,
      Format("a circle at %g degrees in steps of %g degrees, expected -90 to 90 and a step "
             "other than 0 of at most 180",
             elevation / kDegree,
             step / kDegree)};
}

ViewCriterion CircleView(const CircleViewParameters& parameters) {
  return {
      "circle", "rad", [parameters](const PlanningState& state) {
        double azimuth = parameters.step * static_cast<double>(state.visited.size());
        if (!state.visited.empty()) {
          const Eigen::Vector3d first = state.visited.front().translation() - state.target;
          azimuth += std::atan2(first.y(), first.x());
        }
        const double elevation = parameters.elevation;
        Pose next = Pose::Identity();
        next.translation() = state.target + Eigen::Vector3d(std::cos(azimuth) * std::cos(elevation),
                                                            std::sin(azimuth) * std::cos(elevation),
                                                            std::sin(elevation));
        ViewGains gains;
        for (const Pose& candidate : state.candidates) {
          gains.total.push_back(std::numbers::pi - AngleFromTarget(candidate, next, state.target));
        }
        return gains;
      }};
}

}  // namespace vantage
