#include "tools/viewer/orientation_samples.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "common/so3.h"
#include "fusion/so3_grid.h"

namespace vantage {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kLeastWeight = 0.02;  // Of a spot.

// The grid used last: a run has one k.
std::shared_ptr<const So3Grid> GridOf(int k) {
  static std::shared_ptr<const So3Grid> latest;
  if (!latest || latest->k() != k) latest = std::make_shared<const So3Grid>(k);
  return latest;
}

}  // namespace

std::vector<OrientationSample> SamplesOf(const orientation_histogram_t& histogram) {
  std::vector<OrientationSample> samples;
  if (histogram.k < So3Grid::kSmallest || histogram.k > So3Grid::kLargest) return samples;
  const std::shared_ptr<const So3Grid> grid = GridOf(histogram.k);
  const size_t count = std::min(histogram.cell.size(), histogram.weight.size());
  double total = 0.0;
  for (size_t i = 0; i < count; ++i) {
    const double weight = static_cast<double>(histogram.weight[i]);
    if (!grid->IsValid(histogram.cell[i]) || !std::isfinite(weight) || weight <= 0.0) continue;
    const double share = weight * grid->Area(histogram.cell[i]);
    samples.push_back({grid->Representative(histogram.cell[i]), share});
    total += share;
  }
  if (!(total > 0.0)) return {};
  for (OrientationSample& sample : samples) sample.weight /= total;
  return samples;
}

FiberPlace PlaceOf(const Eigen::Quaterniond& q,
                   const Eigen::Vector3d& v,
                   const Eigen::Quaterniond& reference) {
  FiberPlace place;
  place.direction = (q * v).normalized();
  const Eigen::Quaterniond carry =
      Eigen::Quaterniond::FromTwoVectors(reference * v, place.direction);
  // A rotation about `direction`: twice the angle of its w and its part along there.
  const Eigen::Quaterniond twist = q * (carry * reference).conjugate();
  const double angle = 2.0 * std::atan2(twist.vec().dot(place.direction), twist.w());
  place.angle = std::remainder(angle, 2.0 * kPi);
  if (place.angle >= kPi) place.angle -= 2.0 * kPi;
  return place;
}

std::vector<FiberSpot> FindSpots(const std::vector<OrientationSample>& samples,
                                 const Eigen::Vector3d& v,
                                 const Eigen::Quaterniond& reference,
                                 double radius,
                                 size_t count) {
  std::vector<FiberPlace> places;
  places.reserve(samples.size());
  for (const OrientationSample& sample : samples) places.push_back(PlaceOf(sample.q, v, reference));
  const double cos_radius = std::cos(radius);
  std::vector<bool> is_taken(samples.size(), false);
  std::vector<FiberSpot> spots;
  for (size_t n = 0; n < count; ++n) {
    // The heaviest sample's neighborhood, its middle moved to the mean of what it holds.
    size_t heaviest = samples.size();
    for (size_t i = 0; i < samples.size(); ++i) {
      if (is_taken[i]) continue;
      if (heaviest == samples.size() || samples[i].weight > samples[heaviest].weight) heaviest = i;
    }
    if (heaviest == samples.size()) break;
    FiberSpot spot;
    spot.direction = places[heaviest].direction;
    for (int pass = 0; pass < 3; ++pass) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (size_t i = 0; i < samples.size(); ++i) {
        if (is_taken[i] || places[i].direction.dot(spot.direction) < cos_radius) continue;
        sum += samples[i].weight * places[i].direction;
      }
      if (sum.norm() > 0.0) spot.direction = sum.normalized();
    }
    is_taken[heaviest] = true;
    for (size_t i = 0; i < samples.size(); ++i) {
      if (i != heaviest && (is_taken[i] || places[i].direction.dot(spot.direction) < cos_radius)) {
        continue;
      }
      is_taken[i] = true;
      spot.weight += samples[i].weight;
      const double bin = (places[i].angle + kPi) / (2.0 * kPi) * FiberSpot::kNumBins;
      spot.bins[std::min(static_cast<size_t>(bin), FiberSpot::kNumBins - 1)] += samples[i].weight;
    }
    if (spot.weight >= kLeastWeight) spots.push_back(std::move(spot));
  }
  std::sort(spots.begin(), spots.end(), [](const FiberSpot& a, const FiberSpot& b) {
    return a.weight > b.weight;
  });
  return spots;
}

}  // namespace vantage
