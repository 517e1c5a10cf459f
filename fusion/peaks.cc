#include "fusion/peaks.h"

#include <algorithm>
#include <cmath>

#include "common/format.h"
#include "common/so3.h"
#include "fusion/quaternion_mean.h"

namespace vantage {
namespace {

using Cell = So3Grid::Cell;

// Grows clusters through an orientation histogram; every cell belongs to one at most.
class RegionGrowing {
 public:
  explicit RegionGrowing(const OrientationHistogram& histogram)
      : histogram_(histogram), cluster_of_(histogram.entries().size(), 0) {}

  struct Cluster {
    std::vector<size_t> places;  // In the histogram's entries; the seed first.
    bool meets_another = false;  // Grew up to a cell that an earlier cluster has.
  };

  [[nodiscard]] bool taken(size_t place) const { return cluster_of_[place] != 0; }

  // All cells of `threshold` or more that are connected to `seed` (step 2 of paper 5.2).
  Cluster Grow(size_t seed, double threshold) {
    Cluster cluster;
    cluster.places.push_back(seed);
    cluster_of_[seed] = ++num_clusters_;
    for (size_t next = 0; next < cluster.places.size(); ++next) {
      histogram_.grid().Neighbors(histogram_.entries()[cluster.places[next]].cell, &neighbors_);
      for (const Cell neighbor : neighbors_) {
        const int found = histogram_.Find(neighbor);
        if (found < 0) continue;
        const auto place = static_cast<size_t>(found);
        if (histogram_.entries()[place].weight < threshold) continue;
        if (cluster_of_[place] == 0) {
          cluster_of_[place] = num_clusters_;
          cluster.places.push_back(place);
        } else if (cluster_of_[place] != num_clusters_) {
          cluster.meets_another = true;
        }
      }
    }
    return cluster;
  }

 private:
  const OrientationHistogram& histogram_;
  std::vector<int> cluster_of_;  // By place; from 1, 0 for none.
  int num_clusters_ = 0;
  std::vector<Cell> neighbors_;
};

// Equations 6 and 7.
OrientationPeak Average(const OrientationHistogram& histogram,
                        const std::vector<size_t>& places,
                        double total_mass) {
  const So3Grid& grid = histogram.grid();
  std::vector<WeightedOrientation> orientations;
  double mass = 0.0;
  for (const size_t place : places) {
    const OrientationHistogram::Entry& entry = histogram.entries()[place];
    const double weight = entry.weight * grid.Area(entry.cell);
    orientations.push_back({grid.Representative(entry.cell), weight});
    mass += weight;
  }
  OrientationPeak peak;
  peak.weight = mass / total_mass;
  if (mass <= 0.0) {  // Cells that touch the sphere in a point only.
    peak.q = orientations.front().q;
    return peak;
  }
  peak.q = WeightedMean(orientations);
  double square_sum = 0.0;
  for (const WeightedOrientation& orientation : orientations) {
    const double angle = GeodesicAngle(orientation.q, peak.q);
    square_sum += orientation.weight * angle * angle;
  }
  peak.spread = std::sqrt(square_sum / mass);
  return peak;
}

void SortByWeight(std::vector<OrientationPeak>::iterator begin,
                  std::vector<OrientationPeak>::iterator end) {
  std::stable_sort(begin, end, [](const OrientationPeak& a, const OrientationPeak& b) {
    return a.weight > b.weight;
  });
}

}  // namespace

Result<void> PeakParameters::Validate() const {
  if (!(w_min > 0.0 && w_min <= w_max && w_max <= 1.0)) {
    return Error{
        ErrorCode::kInvalidArgument,
        Format("w_min = %g and w_max = %g, expected 0 < w_min <= w_max <= 1", w_min, w_max)};
  }
  if (!(w_mode > 0.0 && w_mode <= 1.0)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("w_mode = %g, expected 0 < w_mode <= 1", w_mode)};
  }
  return {};
}

std::vector<OrientationPeak> FindPeaks(const OrientationHistogram& histogram,
                                       const PeakParameters& parameters) {
  const std::span<const OrientationHistogram::Entry> entries = histogram.entries();
  std::vector<OrientationPeak> peaks;
  const double total_mass = histogram.Mass();
  if (total_mass <= 0.0) return peaks;

  double w_M = 0.0;
  for (const OrientationHistogram::Entry& entry : entries) w_M = std::max(w_M, entry.weight);
  std::vector<size_t> by_weight;  // Heaviest first, equal ones by cell.
  for (size_t i = 0; i < entries.size(); ++i) {
    if (entries[i].weight >= parameters.w_mode * w_M) by_weight.push_back(i);
  }
  std::stable_sort(by_weight.begin(), by_weight.end(), [&](size_t a, size_t b) {
    return entries[a].weight > entries[b].weight;
  });

  RegionGrowing growing(histogram);
  std::ptrdiff_t num_of_paper = 0;
  for (const size_t seed : by_weight) {
    if (growing.taken(seed)) continue;
    const double weight = entries[seed].weight;
    const bool is_of_paper = weight >= parameters.w_max * w_M;
    const double height = is_of_paper ? w_M : weight;
    const RegionGrowing::Cluster cluster = growing.Grow(seed, parameters.w_min * height);
    if (!is_of_paper && cluster.meets_another) continue;  // A shoulder, no mode.
    peaks.push_back(Average(histogram, cluster.places, total_mass));
    if (is_of_paper) ++num_of_paper;
  }
  SortByWeight(peaks.begin(), peaks.begin() + num_of_paper);
  SortByWeight(peaks.begin() + num_of_paper, peaks.end());
  return peaks;
}

}  // namespace vantage
