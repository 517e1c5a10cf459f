#include "tools/evaluate/confusion_strategies.h"

#include <map>
#include <numbers>

#include "common/check.h"
#include "planner/circle_view.h"
#include "planner/confusion_heuristic.h"
#include "planner/farthest_view.h"
#include "planner/information_gain.h"
#include "planner/random_view.h"

namespace vantage {
namespace {

constexpr double kEqualGain = 1e-9;

}  // namespace

std::vector<ConfusionStrategy> ConfusionStrategies(int circle_views) {
  CircleViewParameters circle;
  circle.step = 2.0 * std::numbers::pi / circle_views;
  return {
      {kInformationGainId,
       "information gain",
       [](const std::string&, const ConfusionModel&, uint64_t) { return InformationGainView(); }},
      {kHeuristicId,
       "paper's heuristic",
       [](const std::string& id, const ConfusionModel& model, uint64_t) {
         return ConfusionHeuristicView({{id, &model}});
       }},
      {"farthest",
       "farthest view",
       [](const std::string&, const ConfusionModel&, uint64_t) { return FarthestView(); }},
      {kCircleId,
       "circle",
       [circle](const std::string&, const ConfusionModel&, uint64_t) {
         return CircleView(circle);
       }},
      {kRandomId, "random", [](const std::string&, const ConfusionModel&, uint64_t seed) {
         return RandomView(seed);
       }}};
}

int ChooseView(const ViewCriterion& criterion,
               const PlanningState& state,
               const std::vector<bool>& taken) {
  const std::vector<double> gains = criterion.gains(state).total;
  VANTAGE_CHECK(gains.size() == taken.size(), criterion.name);
  const auto distance = [&](size_t candidate) {
    if (state.visited.empty()) return 0.0;
    return (state.candidates[candidate].translation() - state.visited.back().translation()).norm();
  };
  int best = -1;
  for (size_t i = 0; i < gains.size(); ++i) {
    if (taken[i]) continue;
    if (best >= 0) {
      const auto b = static_cast<size_t>(best);
      if (gains[i] < gains[b] - kEqualGain) continue;
      if (gains[i] <= gains[b] + kEqualGain && distance(i) >= distance(b)) continue;
    }
    best = static_cast<int>(i);
  }
  return best;
}

}  // namespace vantage
