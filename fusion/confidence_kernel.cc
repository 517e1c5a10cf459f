#include "fusion/confidence_kernel.h"

#include <algorithm>
#include <cmath>
#include <limits>

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
  std::vector<So3Grid::Neighbor> neighbors;
  grid.Neighbors(own, &neighbors);
  const auto distance = [&](So3Grid::Cell cell) {
    return grid.Area(cell) > 0.0 ? GeodesicAngle(grid.Representative(cell), q)
                                 : std::numeric_limits<double>::infinity();
  };
  return std::min_element(neighbors.begin(),
                          neighbors.end(),
                          [&](const So3Grid::Neighbor& a, const So3Grid::Neighbor& b) {
                            return distance(a.cell) < distance(b.cell);
                          })
      ->cell;
}

}  // namespace

std::span<const ConfidenceKernel::Cell> ConfidenceKernel::About(const Eigen::Quaterniond& q,
                                                                double sigma) {
  VANTAGE_CHECK(sigma > 0.0, Format("sigma = %g", sigma));
  grid_->CellsWithin(q, kConfidenceCutoff * sigma, &near_);
  cells_.clear();
  double mass = 0.0;
  const double factor = -0.5 / (sigma * sigma);
  for (const So3Grid::NearCell& near : near_) {
    const double weight = std::exp(factor * near.squared_angle);
    cells_.push_back({near.ordinal, weight, near.area, near.cell});
    mass += weight * near.area;
  }
  if (mass <= 0.0) {
    const So3Grid::Cell own = CellWithArea(*grid_, q);
    mass = grid_->Area(own);
    cells_.assign(1, {grid_->Ordinal(own), 1.0, mass, own});
  }
  for (Cell& cell : cells_) cell.density /= mass;
  return cells_;
}

}  // namespace vantage
