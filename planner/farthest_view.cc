#include "planner/farthest_view.h"

namespace vantage {

ViewCriterion FarthestView() {
  return {"farthest", "rad", [](const PlanningState& state) {
            return ViewGains{AnglesToNearestVisited(state), {}};
          }};
}

}  // namespace vantage
