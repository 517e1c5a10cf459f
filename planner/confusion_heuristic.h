#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "fusion/confusion/confusion_model.h"
#include "planner/view_criterion.h"

namespace vantage {

/// The paper's next best view (6.4): viewing directions by how ambiguous detections from there are.
/// Seen from v, the detection q_GT q'_m is made with share K_v(m); its ambiguity is how often it
/// was reported incorrectly when the table was built, the sum over m' > 0 of K_v'(m'), v' being the
/// direction of the truth that it would belie; the directions between are those of the grid. What
/// is missed is no detection to be confused: it counts as one false report. Immutable once made.
class ConfusionHeuristic {
 public:
  explicit ConfusionHeuristic(const ConfusionModel& model);

  /// Expected false reports from a direction, >= 0.
  [[nodiscard]] double FalseReports(int direction) const;
  /// The most from any direction.
  [[nodiscard]] double MostFalseReports() const { return FalseReports(order_.back()); }
  /// All directions, the least ambiguous first, of equal ones the one with the lower index.
  [[nodiscard]] std::span<const int> Order() const { return order_; }
  /// The next view of an object: the first direction in order that was not visited, -1 when all
  /// were. A lookup: one step for each visited direction that comes before it.
  /// @param visited by direction.
  [[nodiscard]] int Next(const std::vector<bool>& visited) const;

 private:
  std::vector<double> false_reports_;
  std::vector<int> order_;
};

/// Criterion. Gain: by how much fewer false reports are expected than from the worst direction, the
/// sum over the objects, each taken to lie as its best hypothesis says and as far as it is not
/// hidden; 0 from directions that an object was seen from before. For objects without a model,
/// AccuracyGain.
/// @param models by model_id; they outlive the criterion.
ViewCriterion ConfusionHeuristicView(const std::map<std::string, const ConfusionModel*>& models);

}  // namespace vantage
