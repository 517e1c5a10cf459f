#include "fusion/orientation_histogram.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/check.h"
#include "common/format.h"

namespace vantage {

OrientationHistogram::OrientationHistogram(const So3Grid& grid, OrientationPrior prior)
    : prior_(std::move(prior)), weights_(grid), kernel_(grid) {}

void OrientationHistogram::Add(const Eigen::Quaterniond& q,
                               double sigma_cw,
                               double verification_weight) {
  VANTAGE_CHECK(verification_weight >= 0.0 && std::isfinite(verification_weight),
                Format("w_v %g", verification_weight));
  const bool uniform = prior_.is_uniform();
  for (const ConfidenceKernel::Cell& cell : kernel_.About(q, sigma_cw)) {
    double weight = verification_weight * cell.density;
    if (!uniform) weight *= prior_.Density(cell.ordinal);
    mass_ += weight * cell.area;
    weights_.Add(cell.ordinal, static_cast<float>(weight));
  }
}

void OrientationHistogram::Vote(const Eigen::Quaterniond& q, double verification_weight) {
  const So3Grid::Cell cell = grid().CellOf(q);
  const int32_t ordinal = grid().Ordinal(cell);
  const double weight = verification_weight * prior_.Density(ordinal);
  mass_ += weight * grid().Area(cell);
  weights_.Add(ordinal, static_cast<float>(weight));
}

void OrientationHistogram::AddDensity(std::span<const Addend> cells, double everywhere) {
  VANTAGE_CHECK(everywhere >= 0.0 && std::isfinite(everywhere), Format("density %g", everywhere));
  for (const Addend& cell : cells) {
    const double weight = cell.density * prior_.Density(cell.ordinal);
    mass_ += weight * cell.area;
    weights_.Add(cell.ordinal, static_cast<float>(weight));
  }
  mass_ += everywhere;  // The mean of the prior's density is 1.
  everywhere_ += everywhere;
}

double OrientationHistogram::Weight(So3Grid::Cell cell) const {
  if (!grid().IsValid(cell)) return 0.0;
  const int32_t ordinal = grid().Ordinal(cell);
  const auto weight = static_cast<double>(weights_.At(ordinal));
  return everywhere_ == 0.0 ? weight : weight + everywhere_ * prior_.Density(ordinal);
}

double OrientationHistogram::Entropy() const {
  double entropy = 0.0;
  const double mass = mass_ - everywhere_;
  for (const CellWeights::Entry& entry : weights_.Entries()) {
    const double share = static_cast<double>(entry.weight) * grid().Area(entry.cell) / mass;
    if (share > 0.0) entropy -= share * std::log(share);
  }
  return std::max(0.0, entropy);
}

}  // namespace vantage
