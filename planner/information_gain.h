#pragma once

#include <span>
#include <vector>

#include "planner/view_criterion.h"

namespace vantage {

/// Mutual information (nat) between the orientation of an object, of which there is a belief, and
/// what will be detected from a place: H(outcomes) - sum over h of b(h) H(outcomes | h). It is the
/// expected fall of the belief's entropy (the paper's future work, section 8; the criterion of
/// Lindley, "On a measure of the information provided by an experiment", 1956). Made once for each
/// object and decision; then a place costs hypotheses x modes.
class InformationGain {
 public:
  /// Hypotheses of less probability, and those after so many, are left out.
  static constexpr double kLeastProbability = 1e-4;
  static constexpr size_t kMostHypotheses = 100;

  /// @param model outlives this.
  /// @param belief best first, not empty.
  InformationGain(const ConfusionModel& model, std::span<const OrientationHypothesis> belief);

  struct Expected {
    double information = 0.0;  ///< nat
    double detected = 0.0;     ///< probability of a detection that is of some mode
  };
  /// @param to_camera direction from the object to the camera, in the world; of any length above 0.
  /// @param unhidden in [0, 1], factor of the probability that the object is found: with 1 - it it
  /// is missed whatever its orientation.
  [[nodiscard]] Expected From(const Eigen::Vector3d& to_camera, double unhidden);

 private:
  const ConfusionModel* model_;
  std::vector<OrientationHypothesis> hypotheses_;  // Their probabilities sum to 1.
  std::vector<int> outcomes_;                      // By hypothesis, then mode.
  std::vector<double> floor_;    // By outcome: probability if nothing but outliers occurred.
  std::vector<double> mixture_;  // By outcome; reused.
};

/// Criterion: the information about all objects, nat, and a tenth of AccuracyGain of each, times
/// the probability that it is detected: what every look brings, small beside what tells hypotheses
/// apart. It leads to views far from those before once the belief is certain, and breaks ties.
/// Of objects without a confusion model or belief AccuracyGain is all that is known, so it counts
/// in full.
ViewCriterion InformationGainView();

}  // namespace vantage
