#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <vector>

#include "common/result.h"
#include "common/so3.h"
#include "fusion/cell_weights.h"
#include "fusion/confidence_kernel.h"
#include "fusion/orientation_fusion.h"
#include "fusion/orientation_prior.h"
#include "fusion/peaks.h"
#include "fusion/so3_grid.h"

namespace vantage {

struct BayesianHistogramParameters {
  double sigma = 4.0 * kDegree;  ///< rad, of the truncated Gaussian that a right detection follows
  double outlier_share = 0.05;   ///< (0, 1), of detections that may be anywhere on SO(3)
  PeakParameters peaks{};

  Result<void> Validate() const;
};

/// Bayesian fusion on the same cells, which the paper sets additive fusion against (5.1): every
/// detection multiplies the posterior by its likelihood, here the confidence weights as a density
/// and a uniform part for outliers. All N cells have a posterior, yet an update costs the touched
/// ones alone: outside of the Gaussian's reach all cells are multiplied by the same number, which
/// the normalization takes out again. So only the logarithm of each cell's posterior over that of
/// an untouched one with the same prior is kept.
class BayesianHistogram : public OrientationFusion {
 public:
  /// @param grid outlives this; parameters are valid; prior of the same grid.
  BayesianHistogram(const So3Grid& grid,
                    const BayesianHistogramParameters& parameters,
                    OrientationPrior prior = {});

  /// The measurement update.
  Result<void> Add(const OrientationView& view) override;
  /// The motion update: the object, or what is known of the camera's pose, turned by a random
  /// rotation. Rotations that the grid can't resolve add up until it can.
  /// @param sigma rad, >= 0, standard deviation in each of three axes.
  void Move(double sigma);

  /// Modes of the posterior, clustered as those of the histogram are (paper 5.2).
  [[nodiscard]] std::vector<OrientationPeak> Peaks() const;
  [[nodiscard]] Result<Eigen::Quaterniond> Estimate() const override;
  /// Posterior density of the cell at a place (So3Grid::Ordinal), relative to the uniform one. The
  /// first call after a change costs the touched cells.
  [[nodiscard]] double Density(int32_t ordinal) const;

 private:
  [[nodiscard]] double LogNormalizer() const;
  [[nodiscard]] std::vector<So3Grid::Neighbor> ModeCells() const;
  void Spread(double sigma);

  OrientationPrior prior_;
  BayesianHistogramParameters parameters_;
  CellWeights log_ratios_;  // >= 0
  ConfidenceKernel kernel_;
  mutable std::optional<double> log_normalizer_ = 0.0;  // None until it is asked for.
  double pending_variance_ = 0.0;                       // rad^2, of motion that was not spread yet.
  bool has_views_ = false;
};

}  // namespace vantage
