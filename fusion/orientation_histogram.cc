#include "fusion/orientation_histogram.h"

#include <algorithm>
#include <cmath>

#include "common/check.h"
#include "common/format.h"
#include "common/so3.h"
#include "fusion/confidence_weight.h"

namespace vantage {
namespace {

// The cell that stands for an orientation by itself: its own, or where that one touches the sphere
// in a point only, the nearest neighbor that has an area.
So3Grid::Cell CellWithArea(const So3Grid& grid, const Eigen::Quaterniond& q) {
  const So3Grid::Cell own = grid.CellOf(q);
  if (grid.Area(own) > 0.0) return own;
  std::vector<So3Grid::Cell> neighbors;
  grid.Neighbors(own, &neighbors);
  return *std::min_element(
      neighbors.begin(), neighbors.end(), [&](So3Grid::Cell a, So3Grid::Cell b) {
        const auto distance = [&](So3Grid::Cell cell) {
          return grid.Area(cell) > 0.0 ? GeodesicAngle(grid.Representative(cell), q) : 10.0;
        };
        return distance(a) < distance(b);
      });
}

}  // namespace

void OrientationHistogram::Add(const Eigen::Quaterniond& q,
                               double sigma_cw,
                               double verification_weight) {
  VANTAGE_CHECK(sigma_cw > 0.0 && verification_weight >= 0.0,
                Format("sigma_cw %g, w_v %g", sigma_cw, verification_weight));
  grid_->CellsWithin(q, kConfidenceCutoff * sigma_cw, &near_);
  added_.clear();
  double mass = 0.0;
  for (const So3Grid::NearCell& near : near_) {
    const double confidence = ConfidenceWeight(near.angle, sigma_cw);
    added_.push_back({near.cell, confidence});
    mass += confidence * grid_->Area(near.cell);
  }
  if (mass <= 0.0) {
    added_.assign(1, {CellWithArea(*grid_, q), 1.0});
    mass = grid_->Area(added_.front().cell);
  }
  for (Entry& entry : added_) entry.weight *= verification_weight / mass;
  Merge(added_);
}

void OrientationHistogram::Merge(std::span<const Entry> added) {
  merged_.clear();
  merged_.reserve(entries_.size() + added.size());
  auto next = added.begin();
  for (const Entry& entry : entries_) {
    while (next != added.end() && next->cell < entry.cell) merged_.push_back(*next++);
    merged_.push_back(entry);
    if (next != added.end() && next->cell == entry.cell) merged_.back().weight += next++->weight;
  }
  merged_.insert(merged_.end(), next, added.end());
  entries_.swap(merged_);
}

int OrientationHistogram::Find(So3Grid::Cell cell) const {
  const auto found = std::lower_bound(
      entries_.begin(), entries_.end(), cell, [](const Entry& entry, So3Grid::Cell wanted) {
        return entry.cell < wanted;
      });
  if (found == entries_.end() || found->cell != cell) return -1;
  return static_cast<int>(found - entries_.begin());
}

double OrientationHistogram::Weight(So3Grid::Cell cell) const {
  const int place = Find(cell);
  return place < 0 ? 0.0 : entries_[static_cast<size_t>(place)].weight;
}

double OrientationHistogram::Mass() const {
  double mass = 0.0;
  for (const Entry& entry : entries_) mass += entry.weight * grid_->Area(entry.cell);
  return mass;
}

double OrientationHistogram::Entropy() const {
  const double mass = Mass();
  double entropy = 0.0;
  for (const Entry& entry : entries_) {
    const double share = entry.weight * grid_->Area(entry.cell) / mass;
    if (share > 0.0) entropy -= share * std::log(share);
  }
  return std::max(0.0, entropy);
}

}  // namespace vantage
