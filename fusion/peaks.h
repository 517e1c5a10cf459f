#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "common/result.h"
#include "fusion/cell_weights.h"
#include "fusion/orientation_histogram.h"

namespace vantage {

/// How clusters of heavy cells are found (paper 5.2).
struct PeakParameters {
  double w_min = 0.7;  ///< Of a cluster's height, that a cell needs to belong to it (paper 7.1).
  double w_max = 0.9;  ///< Of w_M, that a cell needs to begin a cluster (paper 7.1).
  /// Of w_M, that a lower mode needs to be reported beside the paper's clusters.
  double w_mode = 0.3;

  /// 0 < w_min <= w_max <= 1, 0 < w_mode <= 1.
  Result<void> Validate() const;
};

/// A mode of the orientation: a cluster C of the paper's list L_C.
struct OrientationPeak {
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
  /// [0, 1], the cluster's share of the histogram's mass; where OrientationFilter has a belief, the
  /// probability of the hypotheses that the peak stands for.
  double weight = 0.0;
  double spread = 0.0;  ///< rad, root mean square angle of the cluster's mass about q
  /// rad^2, of the cluster's mass about q: of the rotation vectors r, in the world's axes, that
  /// take q to a cell's representative, exp(r) q. Its trace is spread^2.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

/// The final rotation computation of paper 5.2. First come the clusters that grow, through
/// neighboring cells of w_min w_M or more, from cells of w_max w_M or more: the heaviest of these
/// is C_max and its mean q_f (eq. 7). Then, so that alternatives stay visible, modes lower than
/// w_max w_M: clusters grown in the same way around a local maximum, relative to its own height,
/// unless they run into higher ground. Both kinds by descending weight.
/// Costs the touched pages and the cells of the clusters. Empty where all weights are 0.
/// @param total_mass sum of weight times area over all cells.
std::vector<OrientationPeak> FindPeaks(const CellWeights& weights,
                                       double total_mass,
                                       const PeakParameters& parameters);
std::vector<OrientationPeak> FindPeaks(const OrientationHistogram& histogram,
                                       const PeakParameters& parameters);

}  // namespace vantage
