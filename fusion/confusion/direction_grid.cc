#include "fusion/confusion/direction_grid.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/check.h"
#include "common/format.h"
#include "common/so3.h"

namespace vantage {
namespace {

constexpr double kPi = std::numbers::pi;

// Cells in each ring from the north pole down (Leopardi 2006, section 3: as many collars as make
// the cells about as high as wide, each with the number nearest to its share of the area, what is
// rounded off carried on to the next).
std::vector<int> CellsByRing(int num_cells) {
  if (num_cells == 2) return {1, 1};
  const double cap = 2.0 * std::asin(std::sqrt(1.0 / num_cells));  // Colatitude of its border, rad.
  const double height = std::sqrt(4.0 * kPi / num_cells);
  const int num_collars = std::max(1, static_cast<int>(std::lround((kPi - 2.0 * cap) / height)));
  std::vector<int> counts = {1};
  int placed = 1;
  for (int i = 1; i <= num_collars; ++i) {
    const double border = cap + (kPi - 2.0 * cap) * i / num_collars;
    const double ideal = num_cells * 0.5 * (1.0 - std::cos(border));  // Cells above the border.
    counts.push_back(static_cast<int>(std::lround(ideal)) - placed);
    placed += counts.back();
  }
  counts.push_back(1);
  VANTAGE_CHECK(placed == num_cells - 1, "the collars hold all cells but the caps");
  return counts;
}

Eigen::Vector3d UnitVectorAt(double z, double longitude) {
  const double r = std::sqrt(std::max(0.0, (1.0 - z) * (1.0 + z)));
  return {r * std::cos(longitude), r * std::sin(longitude), z};
}

double Angle(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

}  // namespace

DirectionGrid::DirectionGrid(int num_cells) : num_cells_(num_cells) {
  VANTAGE_CHECK(num_cells >= kFewest && num_cells <= kMost,
                Format("%d cells, expected %d to %d", num_cells, kFewest, kMost));
  ring_of_cell_.reserve(static_cast<size_t>(num_cells));
  int first = 0;
  for (const int count : CellsByRing(num_cells)) {
    Ring ring;
    ring.first = first;
    ring.count = count;
    const double highest_z = 1.0 - 2.0 * first / num_cells;
    first += count;
    const double lowest_z = 1.0 - 2.0 * first / num_cells;
    const bool is_cap = ring.first == 0 || first == num_cells;
    // In the middle between the circles, by angle.
    ring.colatitude =
        is_cap ? (ring.first == 0 ? 0.0 : kPi) : 0.5 * (std::acos(highest_z) + std::acos(lowest_z));
    ring_of_cell_.insert(
        ring_of_cell_.end(), static_cast<size_t>(count), static_cast<int>(rings_.size()));
    rings_.push_back(ring);
  }
}

int DirectionGrid::CellOf(const Eigen::Vector3d& direction) const {
  const double norm = direction.stableNorm();
  VANTAGE_CHECK(norm > 0.0 && std::isfinite(norm), "a direction has a length above 0");
  // By the area above it, in cells: rings end at whole numbers, so that the cell at this place is
  // of the ring sought.
  const double above = 0.5 * (1.0 - direction.z() / norm) * num_cells_;
  const int place = std::clamp(static_cast<int>(above), 0, num_cells_ - 1);
  const Ring& ring = RingOf(place);
  double turn = std::atan2(direction.y(), direction.x()) / (2.0 * kPi);
  if (turn < 0.0) turn += 1.0;
  return ring.first + std::min(static_cast<int>(turn * ring.count), ring.count - 1);
}

Eigen::Vector3d DirectionGrid::Center(int cell) const {
  const Ring& ring = RingOf(cell);
  const double longitude = 2.0 * kPi * (cell - ring.first + 0.5) / ring.count;
  if (cell == 0 || cell == num_cells_ - 1) return {0.0, 0.0, cell == 0 ? 1.0 : -1.0};
  const double r = std::sin(ring.colatitude);
  return {r * std::cos(longitude), r * std::sin(longitude), std::cos(ring.colatitude)};
}

Eigen::Vector3d DirectionGrid::Sample(int cell, Rng& rng) const {
  const Ring& ring = RingOf(cell);
  while (true) {
    const double above = ring.first + ring.count * rng.Uniform();
    const double longitude = 2.0 * kPi * (cell - ring.first + rng.Uniform()) / ring.count;
    const Eigen::Vector3d direction = UnitVectorAt(1.0 - 2.0 * above / num_cells_, longitude);
    // Rounding can carry a point on the border across it.
    if (CellOf(direction) == cell) return direction;
  }
}

std::vector<int> DirectionGrid::CellsWithin(const Eigen::Vector3d& direction, double radius) const {
  constexpr double kMargin = 1e-6;  // rad; what is near the border is measured.
  const Eigen::Vector3d unit = direction.stableNormalized();
  const double colatitude = std::atan2(std::hypot(unit.x(), unit.y()), unit.z());
  const double longitude = std::atan2(unit.y(), unit.x());
  std::vector<int> cells;
  for (const Ring& ring : rings_) {
    if (std::abs(ring.colatitude - colatitude) > radius + kMargin) continue;
    // Half the longitudes within: spherical law of cosines.
    const double sines = std::sin(colatitude) * std::sin(ring.colatitude);
    const double cosine = std::cos(std::min(radius + kMargin, kPi)) -
                          std::cos(colatitude) * std::cos(ring.colatitude);
    const double half = sines > std::abs(cosine) ? std::acos(cosine / sines)
                        : cosine > 0.0           ? 0.0
                                                 : kPi;
    const double width = 2.0 * kPi / ring.count;
    const int from = static_cast<int>(std::floor((longitude - half) / width - 0.5));
    const int up_to = std::min(static_cast<int>(std::ceil((longitude + half) / width - 0.5)),
                               from + ring.count - 1);
    const size_t start = cells.size();
    for (int i = from; i <= up_to; ++i) {
      const int cell = ring.first + ((i % ring.count) + ring.count) % ring.count;
      if (Angle(unit, Center(cell)) <= radius) cells.push_back(cell);
    }
    std::sort(cells.begin() + static_cast<std::ptrdiff_t>(start), cells.end());
  }
  return cells;
}

const DirectionGrid::Ring& DirectionGrid::RingOf(int cell) const {
  VANTAGE_CHECK(cell >= 0 && cell < num_cells_, "a cell of the grid of directions");
  return rings_[static_cast<size_t>(ring_of_cell_[static_cast<size_t>(cell)])];
}

int NumDirections(int k) {
  const double spacing = 10.28 * kDegree * 8.0 / k;
  return static_cast<int>(std::ceil(4.0 * kPi / (spacing * spacing)));
}

}  // namespace vantage
