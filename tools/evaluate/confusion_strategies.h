#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "fusion/confusion/confusion_model.h"
#include "planner/view_criterion.h"

namespace vantage {

/// A way to choose the next view, as the report names it.
struct ConfusionStrategy {
  std::string id;     ///< "information_gain"
  std::string label;  ///< "information gain"
  /// @param model_id and model of the object that is looked at. @param seed of a sequence.
  std::function<ViewCriterion(const std::string& model_id, const ConfusionModel& model, uint64_t)>
      make;
};

inline constexpr const char* kInformationGainId = "information_gain";
inline constexpr const char* kHeuristicId = "heuristic";
inline constexpr const char* kCircleId = "circle";
inline constexpr const char* kRandomId = "random";

/// Expected information gain, the paper's heuristic (6.4), the view farthest from those taken, the
/// circle (Fig. 13) and random views.
/// @param circle_views in which the circle is closed.
std::vector<ConfusionStrategy> ConfusionStrategies(int circle_views);

/// The candidate of the largest gain that was not taken, of equal ones (1e-9) the one nearest to
/// where the camera is, then the first; -1 when all were taken.
/// @param taken of each candidate.
int ChooseView(const ViewCriterion& criterion,
               const PlanningState& state,
               const std::vector<bool>& taken);

}  // namespace vantage
