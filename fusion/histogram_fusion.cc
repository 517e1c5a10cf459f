#include "fusion/histogram_fusion.h"

#include <utility>

#include "common/so3.h"
#include "fusion/peaks.h"
#include "fusion/verification_weight.h"

namespace vantage {

HistogramFusion::HistogramFusion(const So3Grid& grid,
                                 FinalOrientation final_orientation,
                                 const OrientationFilterParameters& parameters,
                                 OrientationPrior prior)
    : final_orientation_(final_orientation),
      parameters_(parameters),
      histogram_(grid, std::move(prior)) {}

Result<void> HistogramFusion::Add(const OrientationView& view) {
  if (auto valid = view.Validate(); !valid) return valid;
  const Eigen::Quaterniond q = view.q_world_object.normalized();
  const double w_v = VerificationWeight(view.mse, parameters_.sigma_vw);
  switch (final_orientation_) {
    case FinalOrientation::kVoting:
      histogram_.Vote(q, 1.0);
      break;
    case FinalOrientation::kVwVoting:
      histogram_.Vote(q, w_v);
      break;
    case FinalOrientation::kCwClustering:
      histogram_.Add(q, parameters_.sigma_cw, 1.0);
      break;
    case FinalOrientation::kCwVwClustering:
      histogram_.Add(q, parameters_.sigma_cw, w_v);
      break;
    case FinalOrientation::kDensityMode:
      histogram_.Add(q, parameters_.sigma_cw, w_v);
      kernels_.push_back({q, parameters_.sigma_mode, w_v});
      break;
  }
  return {};
}

Eigen::Quaterniond HistogramFusion::HeaviestCell() const {
  const CellWeights& weights = histogram_.weights();
  const std::vector<CellWeights::Placed> heaviest = weights.AtLeast(weights.Largest());
  std::vector<So3Grid::Cell> cell;
  weights.grid().CellsAt(heaviest.front().ordinal, 1, &cell);
  return weights.grid().Representative(cell.front());
}

Eigen::Quaterniond HistogramFusion::HighestMode(const std::vector<OrientationPeak>& peaks) const {
  DensityMode best;
  for (const OrientationPeak& peak : peaks) {
    const DensityMode mode = FindDensityMode(kernels_, peak.q);
    if (mode.density > best.density) best = mode;
  }
  return best.q;
}

Result<Eigen::Quaterniond> HistogramFusion::Estimate() const {
  if (!(histogram_.weights().Largest() > 0.0F)) {
    return Error{ErrorCode::kNotFound, "no view with weight was fused, so there is no orientation"};
  }
  switch (final_orientation_) {
    case FinalOrientation::kVoting:
    case FinalOrientation::kVwVoting:
      return Canonical(HeaviestCell());
    case FinalOrientation::kCwClustering:
    case FinalOrientation::kCwVwClustering:
      return Canonical(FindPeaks(histogram_, parameters_.peaks).front().q);
    case FinalOrientation::kDensityMode:
      break;
  }
  return HighestMode(FindPeaks(histogram_, parameters_.peaks));
}

}  // namespace vantage
