#include "planner/random_view.h"

#include "common/rng.h"

namespace vantage {

ViewCriterion RandomView(uint64_t seed) {
  return {"random", "", [seed](const PlanningState& state) {
            Rng rng(seed, state.visited.size());
            ViewGains gains;
            for (size_t i = 0; i < state.candidates.size(); ++i) {
              gains.total.push_back(rng.Uniform());
            }
            return gains;
          }};
}

}  // namespace vantage
