#include "fusion/peaks.h"

#include <algorithm>
#include <cmath>

#include "common/format.h"
#include "common/so3.h"
#include "fusion/quaternion_mean.h"

namespace vantage {
namespace {

// Cells that may belong to a cluster, by place.
using Candidates = std::vector<CellWeights::Placed>;

// Grows clusters through the weights; every cell belongs to one at most.
class RegionGrowing {
 public:
  /// @param candidates all cells that any cluster may hold.
  RegionGrowing(const CellWeights& weights, const Candidates& candidates)
      : weights_(weights), candidates_(candidates), cluster_of_(candidates.size(), 0) {}

  struct Cluster {
    std::vector<CellWeights::Entry> cells;  // The seed first.
    bool meets_another = false;             // Grew up to a cell that an earlier cluster has.
  };

  [[nodiscard]] bool taken(size_t candidate) const { return cluster_of_[candidate] != 0; }

  // All cells of `threshold` or more that are connected to `seed` (step 2 of paper 5.2).
  Cluster Grow(size_t seed, float threshold) {
    Cluster cluster;
    const CellWeights::Placed& first = candidates_[seed];
    weights_.grid().CellsAt(first.ordinal, 1, &seed_cell_);
    cluster.cells.push_back({seed_cell_.front(), first.weight});
    cluster_of_[seed] = ++num_clusters_;
    for (size_t next = 0; next < cluster.cells.size(); ++next) {
      weights_.grid().Neighbors(cluster.cells[next].cell, &neighbors_);
      for (const So3Grid::Neighbor& neighbor : neighbors_) {
        const float weight = weights_.At(neighbor.ordinal);
        if (weight < threshold) continue;
        int& owner = cluster_of_[Find(neighbor.ordinal)];
        if (owner == 0) {
          owner = num_clusters_;
          cluster.cells.push_back({neighbor.cell, weight});
        } else if (owner != num_clusters_) {
          cluster.meets_another = true;
        }
      }
    }
    return cluster;
  }

 private:
  [[nodiscard]] size_t Find(int32_t ordinal) const {
    const auto found = std::lower_bound(
        candidates_.begin(),
        candidates_.end(),
        ordinal,
        [](const CellWeights::Placed& a, int32_t wanted) { return a.ordinal < wanted; });
    return static_cast<size_t>(found - candidates_.begin());
  }

  const CellWeights& weights_;
  const Candidates& candidates_;
  std::vector<int> cluster_of_;  // By candidate; from 1, 0 for none.
  int num_clusters_ = 0;
  std::vector<So3Grid::Neighbor> neighbors_;
  std::vector<So3Grid::Cell> seed_cell_;
};

// Equations 6 and 7.
OrientationPeak Average(const So3Grid& grid,
                        const std::vector<CellWeights::Entry>& cells,
                        double total_mass) {
  std::vector<WeightedOrientation> orientations;
  orientations.reserve(cells.size());
  double mass = 0.0;
  for (const CellWeights::Entry& entry : cells) {
    const double weight = static_cast<double>(entry.weight) * grid.Area(entry.cell);
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
  const Eigen::Quaterniond q_inverse = peak.q.conjugate();
  for (const WeightedOrientation& orientation : orientations) {
    const Eigen::Vector3d r = LogSo3(orientation.q * q_inverse);
    peak.covariance += orientation.weight / mass * r * r.transpose();
  }
  peak.spread = std::sqrt(peak.covariance.trace());
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

std::vector<OrientationPeak> FindPeaks(const CellWeights& weights,
                                       double total_mass,
                                       const PeakParameters& parameters) {
  std::vector<OrientationPeak> peaks;
  const float w_M = weights.Largest();
  if (!(total_mass > 0.0 && w_M > 0.0F)) return peaks;
  const auto w_min = static_cast<float>(parameters.w_min);
  const float seed_threshold =
      static_cast<float>(std::min(parameters.w_mode, parameters.w_max)) * w_M;
  const float paper_threshold = static_cast<float>(parameters.w_max) * w_M;
  const Candidates candidates = weights.AtLeast(w_min * seed_threshold);
  std::vector<size_t> by_weight;  // Heaviest first, equal ones by place.
  for (size_t i = 0; i < candidates.size(); ++i) {
    if (candidates[i].weight >= seed_threshold) by_weight.push_back(i);
  }
  std::stable_sort(by_weight.begin(), by_weight.end(), [&](size_t a, size_t b) {
    return candidates[a].weight > candidates[b].weight;
  });

  RegionGrowing growing(weights, candidates);
  std::ptrdiff_t num_of_paper = 0;
  for (const size_t seed : by_weight) {
    if (growing.taken(seed)) continue;
    const float weight = candidates[seed].weight;
    const bool is_of_paper = weight >= paper_threshold;
    const RegionGrowing::Cluster cluster = growing.Grow(seed, w_min * (is_of_paper ? w_M : weight));
    if (!is_of_paper && cluster.meets_another) continue;  // A shoulder, no mode.
    peaks.push_back(Average(weights.grid(), cluster.cells, total_mass));
    if (is_of_paper) ++num_of_paper;
  }
  SortByWeight(peaks.begin(), peaks.begin() + num_of_paper);
  SortByWeight(peaks.begin() + num_of_paper, peaks.end());
  return peaks;
}

std::vector<OrientationPeak> FindPeaks(const OrientationHistogram& histogram,
                                       const PeakParameters& parameters) {
  return FindPeaks(histogram.weights(), histogram.Mass(), parameters);
}

}  // namespace vantage
