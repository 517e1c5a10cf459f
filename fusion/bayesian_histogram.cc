#include "fusion/bayesian_histogram.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "common/check.h"
#include "common/format.h"

namespace vantage {
namespace {

// Cells of less than e^-16 of the highest posterior density belong to no cluster.
constexpr double kDepth = 16.0;

}  // namespace

Result<void> BayesianHistogramParameters::Validate() const {
  if (!(sigma > 0.0 && sigma <= std::numbers::pi)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("sigma = %g rad, expected above 0 and at most pi", sigma)};
  }
  if (!(outlier_share > 0.0 && outlier_share < 1.0)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("outlier_share = %g, expected between 0 and 1", outlier_share)};
  }
  return peaks.Validate();
}

BayesianHistogram::BayesianHistogram(const So3Grid& grid,
                                     const BayesianHistogramParameters& parameters,
                                     OrientationPrior prior)
    : prior_(std::move(prior)), parameters_(parameters), log_ratios_(grid), kernel_(grid) {}

Result<void> BayesianHistogram::Add(const OrientationView& view) {
  if (auto valid = view.Validate(); !valid) return valid;
  const double odds = (1.0 - parameters_.outlier_share) / parameters_.outlier_share;
  for (const auto& cell : kernel_.About(view.q_world_object.normalized(), parameters_.sigma)) {
    log_ratios_.Add(cell.ordinal, static_cast<float>(std::log1p(odds * cell.density)));
  }
  has_views_ = true;
  log_normalizer_.reset();
  return {};
}

void BayesianHistogram::Move(double sigma) {
  VANTAGE_CHECK(sigma >= 0.0 && std::isfinite(sigma), Format("sigma = %g rad", sigma));
  pending_variance_ += sigma * sigma;
  // Narrower than the mean distance of neighbors (paper Table 1: 1.44 rad / k) a kernel would stay
  // in its own cell.
  const double resolvable = 1.44 / log_ratios_.grid().k();
  if (pending_variance_ < resolvable * resolvable) return;
  Spread(std::sqrt(pending_variance_));
  pending_variance_ = 0.0;
}

// Convolves what the posterior has above the prior; the prior itself is what motion leads to.
void BayesianHistogram::Spread(double sigma) {
  const So3Grid& grid = log_ratios_.grid();
  // Relative to the largest ratio, so that nothing overflows.
  const double largest = static_cast<double>(log_ratios_.Largest());
  CellWeights spread(grid);
  for (const CellWeights::Entry& entry : log_ratios_.Entries()) {
    const double above = std::exp(static_cast<double>(entry.weight) - largest) - std::exp(-largest);
    const int32_t ordinal = grid.Ordinal(entry.cell);
    const double mass = above * grid.Area(entry.cell) * prior_.Density(ordinal);
    for (const auto& cell : kernel_.About(grid.Representative(entry.cell), sigma)) {
      spread.Add(cell.ordinal, static_cast<float>(mass * cell.density));
    }
  }
  CellWeights log_ratios(grid);
  for (const CellWeights::Entry& entry : spread.Entries()) {
    const int32_t ordinal = grid.Ordinal(entry.cell);
    const double prior = prior_.Density(ordinal);
    if (prior <= 0.0) continue;
    const double above = static_cast<double>(entry.weight) / prior;
    const double log_ratio = largest + std::log(std::exp(-largest) + above);
    log_ratios.Add(ordinal, static_cast<float>(std::max(0.0, log_ratio)));
  }
  log_ratios_ = std::move(log_ratios);
  log_normalizer_.reset();
}

// Cells that a mode may hold: touched ones, and those that the prior favors.
std::vector<So3Grid::Neighbor> BayesianHistogram::ModeCells() const {
  const So3Grid& grid = log_ratios_.grid();
  const double largest = static_cast<double>(log_ratios_.Largest());
  std::vector<So3Grid::Neighbor> found;
  if (prior_.is_uniform()) {
    if (largest <= 0.0) return found;
    const auto least = static_cast<float>(std::max(largest - kDepth, 0.1 * largest));
    std::vector<So3Grid::Cell> cell;
    for (const CellWeights::Placed& placed : log_ratios_.AtLeast(least)) {
      grid.CellsAt(placed.ordinal, 1, &cell);
      found.push_back({cell.front(), placed.ordinal});
    }
    return found;
  }
  for (const CellWeights::Entry& entry : log_ratios_.Entries()) {
    found.push_back({entry.cell, grid.Ordinal(entry.cell)});
  }
  for (const CellWeights::Entry& entry : prior_.AboveElsewhere()) {
    const int32_t ordinal = grid.Ordinal(entry.cell);
    if (log_ratios_.At(ordinal) == 0.0F) found.push_back({entry.cell, ordinal});
  }
  return found;
}

std::vector<OrientationPeak> BayesianHistogram::Peaks() const {
  const So3Grid& grid = log_ratios_.grid();
  const std::vector<So3Grid::Neighbor> cells = ModeCells();
  const auto log_density = [this](int32_t ordinal) {  // Minus infinity where it is excluded.
    return static_cast<double>(log_ratios_.At(ordinal)) + std::log(prior_.Density(ordinal));
  };
  double highest = -std::numeric_limits<double>::infinity();
  for (const So3Grid::Neighbor& cell : cells) {
    highest = std::max(highest, log_density(cell.ordinal));
  }
  if (!std::isfinite(highest)) return {};
  CellWeights posterior(grid);
  double mass = 0.0;
  for (const So3Grid::Neighbor& cell : cells) {
    const double height = log_density(cell.ordinal) - highest;
    if (height < -kDepth) continue;
    posterior.Add(cell.ordinal, static_cast<float>(std::exp(height)));
    mass += std::exp(height) * grid.Area(cell.cell);
  }
  std::vector<OrientationPeak> peaks = FindPeaks(posterior, mass, parameters_.peaks);
  const double share = mass * std::exp(highest - LogNormalizer());
  for (OrientationPeak& peak : peaks) peak.weight *= share;
  return peaks;
}

Result<Eigen::Quaterniond> BayesianHistogram::Estimate() const {
  const std::vector<OrientationPeak> peaks = Peaks();
  if (!has_views_ || peaks.empty()) {
    return Error{ErrorCode::kNotFound, "no view was fused, so there is no orientation"};
  }
  return Canonical(peaks.front().q);
}

// Logarithm of the sum over all cells of area * prior density * ratio.
double BayesianHistogram::LogNormalizer() const {
  if (log_normalizer_) return *log_normalizer_;
  const So3Grid& grid = log_ratios_.grid();
  const double largest = static_cast<double>(log_ratios_.Largest());
  double sum = std::exp(-largest);  // Of the prior itself, whose mass is 1.
  for (const CellWeights::Entry& entry : log_ratios_.Entries()) {
    const double above = std::exp(static_cast<double>(entry.weight) - largest) - std::exp(-largest);
    sum += above * grid.Area(entry.cell) * prior_.Density(grid.Ordinal(entry.cell));
  }
  log_normalizer_ = largest + std::log(sum);
  return *log_normalizer_;
}

double BayesianHistogram::Density(int32_t ordinal) const {
  const double log_ratio = static_cast<double>(log_ratios_.At(ordinal));
  return prior_.Density(ordinal) * std::exp(log_ratio - LogNormalizer());
}

}  // namespace vantage
