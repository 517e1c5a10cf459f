#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "fusion/bingham/bingham_distribution.h"

namespace vantage {

struct BinghamComponent {
  double log_weight = 0.0;
  BinghamDistribution distribution;
};

/// A weighted sum of Bingham distributions (Riedel, Marton and Kriegel 2016).
class BinghamMixture {
 public:
  /// @param components at least one, log weights finite; the weights are scaled to sum 1.
  explicit BinghamMixture(std::vector<BinghamComponent> components);

  [[nodiscard]] const std::vector<BinghamComponent>& components() const { return components_; }
  [[nodiscard]] double LogDensity(const Eigen::Quaterniond& q) const;
  /// The orientation of highest density, canonical: upwards from the best of the components' modes.
  [[nodiscard]] Eigen::Quaterniond Mode() const;

  /// Leaves at most `max_components` >= 1 besides a uniform one. The pair whose scatters are the
  /// most alike is replaced, again and again, by the distribution of its weighted scatter. Alike is
  /// a small Jensen-Bregman LogDet divergence, log det((S + T) / 2) - log det(S T) / 2 (Cherian,
  /// Sra, Banerjee and Papanikolopoulos 2013): for narrow distributions twice the entropy that
  /// merging two of equal weight adds. It takes no notice of the weights, so that a second
  /// orientation that was seen a few times is not given up for the sake of details of the first.
  /// Before that, components of less than exp(-1000) of the heaviest are dropped, which some
  /// hundred more agreeing views could not bring back. The uniform component, which stands for "all
  /// detections so far were outliers", is where new orientations come from, and is neither dropped
  /// nor merged.
  void Reduce(int max_components);

 private:
  void Normalize();

  std::vector<BinghamComponent> components_;
};

/// The normalized product: Bayes' rule for a prior and a likelihood.
BinghamMixture Multiply(const BinghamMixture& a, const BinghamMixture& b);

}  // namespace vantage
