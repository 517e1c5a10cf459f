#pragma once

#include <Eigen/Geometry>
#include <span>

namespace vantage {

/// An orientation and how much it counts.
struct WeightedOrientation {
  Eigen::Quaterniond q;
  double weight;
};

/// The weighted mean orientation (paper eq. 7): the normalized sum of the quaternions, all turned
/// to the same side as the first one, which is the closed form of Sharf et al. 2010. Where they lie
/// so far apart that the side is in doubt, the chordal mean: the largest eigenvector of the
/// weighted sum of q q^T, which has no sides.
/// @param orientations at least one, weights >= 0 with a positive sum.
Eigen::Quaterniond WeightedMean(std::span<const WeightedOrientation> orientations);

}  // namespace vantage
