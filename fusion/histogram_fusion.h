#pragma once

#include <Eigen/Geometry>
#include <array>
#include <vector>

#include "common/result.h"
#include "fusion/density_mode.h"
#include "fusion/orientation_filter.h"
#include "fusion/orientation_fusion.h"
#include "fusion/orientation_histogram.h"
#include "fusion/orientation_prior.h"

namespace vantage {

/// How the final orientation q_f comes from the histogram: the four ways of paper 5.2, and the
/// exact mode of the density that the histogram stands for.
enum class FinalOrientation {
  kVoting,          ///< representative of the cell with most detections
  kVwVoting,        ///< the same, each detection counting w_v (eq. 4)
  kCwClustering,    ///< mean of the heaviest cluster (eq. 7) of confidence weights (eq. 3)
  kCwVwClustering,  ///< the same with verification weights too (eq. 5)
  kDensityMode,     ///< mean shift from that cluster's mean over the raw weighted detections
};
inline constexpr std::array<FinalOrientation, 5> kFinalOrientations = {
    FinalOrientation::kVoting,
    FinalOrientation::kVwVoting,
    FinalOrientation::kCwClustering,
    FinalOrientation::kCwVwClustering,
    FinalOrientation::kDensityMode};

/// The histogram filter (paper section 5) with one of the final orientations.
class HistogramFusion : public OrientationFusion {
 public:
  /// @param grid outlives this; parameters are valid (of them sigma_cw, sigma_vw, sigma_mode and
  /// peaks are used); prior of the same grid.
  HistogramFusion(const So3Grid& grid,
                  FinalOrientation final_orientation,
                  const OrientationFilterParameters& parameters,
                  OrientationPrior prior = {});

  Result<void> Add(const OrientationView& view) override;
  [[nodiscard]] Result<Eigen::Quaterniond> Estimate() const override;

  [[nodiscard]] const OrientationHistogram& histogram() const { return histogram_; }

 private:
  [[nodiscard]] Eigen::Quaterniond HeaviestCell() const;
  [[nodiscard]] Eigen::Quaterniond HighestMode(const std::vector<OrientationPeak>& peaks) const;

  FinalOrientation final_orientation_;
  OrientationFilterParameters parameters_;
  OrientationHistogram histogram_;
  std::vector<OrientationKernel> kernels_;  // For kDensityMode.
};

}  // namespace vantage
