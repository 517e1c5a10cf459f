#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "fusion/confusion/confusion_model.h"

namespace vantage {

/// One look at an object whose confusion model is known.
struct ConfusionView {
  Eigen::Quaterniond q_world_camera = Eigen::Quaterniond::Identity();
  std::optional<Eigen::Quaterniond> q_world_object;  ///< as detected; none: looked, not found
};

/// An orientation that the object may have, standing for all within a mode's radius.
struct OrientationHypothesis {
  Eigen::Quaterniond q_world_object = Eigen::Quaterniond::Identity();
  double probability = 0.0;
};

/// The posterior over the orientations that detections allow: every detection may stand for any
/// truth q_D q'* with a mode's difference rotation q', and every view multiplies the probability of
/// each truth by the share of what was detected from there (Bayes; the additive filter of paper
/// section 5 stays beside it for the final orientation). Probabilities sum to 1, best first, those
/// below 1e-6 left out; orientations that the object's symmetry makes equal are one.
/// @param views in any order; empty views give an empty belief.
std::vector<OrientationHypothesis> ModeBelief(const ConfusionModel& model,
                                              const std::vector<ConfusionView>& views);

/// Entropy of a belief, nat.
double BeliefEntropy(const std::vector<OrientationHypothesis>& belief);

}  // namespace vantage
