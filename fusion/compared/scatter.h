#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace vantage {

/// The chordal mean of orientations and how closely they lie about it.
struct ScatterMean {
  Eigen::Quaterniond mean;  ///< canonical
  double concentration;     ///< mean squared cosine of half the angle to it, 1/4..1
};

/// @param scatter the sum of q q^T over one or more unit quaternions.
ScatterMean MeanOfScatter(const Eigen::Matrix4d& scatter);

}  // namespace vantage
