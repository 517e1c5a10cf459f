#include "fusion/so3_grid.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "common/check.h"
#include "common/format.h"
#include "common/so3.h"
#include "fusion/sphere_patch.h"

namespace vantage {
namespace {

int Square(int value) { return value * value; }

// Orders in which four sorted numbers can appear, counting equal ones once.
int NumPermutations(const std::array<int, 4>& sorted) {
  int permutations = 24;
  int run = 1;
  for (size_t i = 1; i < 4; ++i) {
    run = sorted[i] == sorted[i - 1] ? run + 1 : 1;
    permutations /= run;
  }
  return permutations;
}

// Squared distances from 0 of the nearest and the farthest corner, in cells.
std::pair<int, int> CornerDistances(const std::array<int, 4>& lower) {
  int nearest = 0;
  int farthest = 0;
  for (const int i : lower) {
    nearest += Square(i);
    farthest += Square(i + 1);
  }
  return {nearest, farthest};
}

}  // namespace

So3Grid::So3Grid(int k) : k_(k) {
  VANTAGE_CHECK(k >= kSmallest && k <= kLargest, Format("k = %d, expected 2..128", k));
  for (int c = 0; c <= k; ++c) tetrahedral_.push_back(c * (c + 1) * (c + 2) / 6);
  first_patch_.resize(TripleSlot(0, 0, k), 0);
  for (int c = 0; c < k; ++c) {
    for (int b = 0; b <= c; ++b) {
      for (int a = 0; a <= b; ++a) {
        bool first = true;
        for (int d = c; d < k; ++d) {
          const std::array<int, 4> lower = {a, b, c, d};
          const auto [nearest, farthest] = CornerDistances(lower);
          if (nearest > Square(k) || farthest < Square(k)) continue;
          if (first) {
            first_patch_[TripleSlot(a, b, c)] = static_cast<int32_t>(patches_.size()) - d;
            first = false;
          }
          const SpherePatch patch = IntegrateSpherePatch(lower, k);
          const Eigen::Vector4f centroid = patch.centroid.cast<float>();
          patches_.push_back({patch.area, {centroid[0], centroid[1], centroid[2], centroid[3]}});
          num_cells_ += 8 * NumPermutations(lower);  // 8: the signs of x, y, z.
        }
      }
    }
  }
  patches_.shrink_to_fit();

  lowest_.resize(static_cast<size_t>(Square(k)));
  for (int iw = 0, rest = 0; rest < Square(k); ++rest) {
    if (Square(iw + 1) < rest) ++iw;
    lowest_[static_cast<size_t>(rest)] = static_cast<int16_t>(iw);
  }
  column_first_.resize(ColumnSlot(k, 0, 0));
  int num_before = 0;
  for (int a = 0; a < k; ++a) {
    for (int b = 0; b < k; ++b) {
      for (int c = 0; c < k; ++c) {
        int32_t& first = column_first_[ColumnSlot(a, b, c)];
        first = num_before;
        const int nearest = Square(a) + Square(b) + Square(c);
        if (nearest > Square(k)) continue;
        const int lowest = LowestInColumn(Square(a + 1) + Square(b + 1) + Square(c + 1));
        first -= lowest;
        int iw = lowest;
        while (iw < k && nearest + Square(iw) <= Square(k)) ++iw;
        num_before += iw - lowest;
      }
    }
  }
  VANTAGE_CHECK(num_cells_ == 8 * num_before, "columns hold other cells than patches stand for");
}

Result<So3Grid> So3Grid::Create(int k) {
  if (k < kSmallest || k > kLargest) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("k = %d, expected %d..%d", k, kSmallest, kLargest)};
  }
  return So3Grid(k);
}

size_t So3Grid::bytes() const {
  return sizeof(*this) + column_first_.capacity() * sizeof(column_first_[0]) +
         tetrahedral_.capacity() * sizeof(tetrahedral_[0]) +
         lowest_.capacity() * sizeof(lowest_[0]) +
         first_patch_.capacity() * sizeof(first_patch_[0]) +
         patches_.capacity() * sizeof(patches_[0]);
}

So3Grid::Index So3Grid::IndexOf(Cell cell) const {
  const int iw = cell % k_;
  const int xyz = cell / k_;
  return {xyz / (4 * k_ * k_), xyz / (2 * k_) % (2 * k_), xyz % (2 * k_), iw};
}

So3Grid::Column So3Grid::ColumnAt(int ix, int iy, int iz) const {
  Column column{};
  column.lower = {ReflectedLower(ix), ReflectedLower(iy), ReflectedLower(iz)};
  column.sign = {ix >= k_ ? 1.0 : -1.0, iy >= k_ ? 1.0 : -1.0, iz >= k_ ? 1.0 : -1.0};
  column.sorted = column.lower;
  column.axis = {0, 1, 2};
  const auto sort_pair = [&](size_t i, size_t j) {
    if (column.sorted[i] <= column.sorted[j]) return;
    std::swap(column.sorted[i], column.sorted[j]);
    std::swap(column.axis[i], column.axis[j]);
  };
  sort_pair(0, 1);
  sort_pair(1, 2);
  sort_pair(0, 1);
  for (const int i : column.lower) {
    column.nearest += Square(i);
    column.farthest += Square(i + 1);
  }
  return column;
}

So3Grid::Placed So3Grid::PatchIn(const Column& column, int iw) const {
  const auto [a, b, c] = column.sorted;
  const auto patch = [this](int i, int j, int m, int largest) {
    return &patches_[static_cast<size_t>(first_patch_[TripleSlot(i, j, m)] + largest)];
  };
  if (iw >= c) return {patch(a, b, c, iw), 3};
  if (iw >= b) return {patch(a, b, iw, c), 2};
  if (iw >= a) return {patch(a, iw, b, c), 1};
  return {patch(iw, a, b, c), 0};
}

Eigen::Vector4d So3Grid::Point(const Column& column, const Placed& placed) {
  const std::array<float, 4>& centroid = placed.patch->centroid;
  Eigen::Vector4d point;
  point[3] = static_cast<double>(centroid[static_cast<size_t>(placed.rank_of_w)]);
  for (int i = 0; i < 3; ++i) {
    const auto axis = static_cast<size_t>(column.axis[static_cast<size_t>(i)]);
    const auto rank = static_cast<size_t>(i < placed.rank_of_w ? i : i + 1);
    point[static_cast<Eigen::Index>(axis)] =
        column.sign[axis] * static_cast<double>(centroid[rank]);
  }
  return point;
}

bool So3Grid::MeetsSphere(const Index& index) const {
  const auto [nearest, farthest] = CornerDistances(
      {ReflectedLower(index[0]), ReflectedLower(index[1]), ReflectedLower(index[2]), index[3]});
  return nearest <= Square(k_) && Square(k_) <= farthest;
}

bool So3Grid::IsValid(Cell cell) const {
  const int64_t lattice = int64_t{8} * k_ * k_ * k_ * k_;
  return cell >= 0 && cell < lattice && MeetsSphere(IndexOf(cell));
}

std::vector<So3Grid::Cell> So3Grid::ValidCells() const {
  std::vector<Cell> cells;
  cells.reserve(static_cast<size_t>(num_cells_));
  for (int ix = 0; ix < 2 * k_; ++ix) {
    for (int iy = 0; iy < 2 * k_; ++iy) {
      for (int iz = 0; iz < 2 * k_; ++iz) {
        for (int iw = 0; iw < k_; ++iw) {
          const Index index = {ix, iy, iz, iw};
          if (MeetsSphere(index)) cells.push_back(CellAt(index));
        }
      }
    }
  }
  return cells;
}

int32_t So3Grid::OrdinalAt(const Index& index) const {
  const auto [ix, iy, iz, iw] = index;
  const size_t slot = ColumnSlot(ReflectedLower(ix), ReflectedLower(iy), ReflectedLower(iz));
  return OctantFirst(ix, iy, iz) + column_first_[slot] + iw;
}

int32_t So3Grid::Ordinal(Cell cell) const { return OrdinalAt(IndexOf(cell)); }

// Place in the octant of a column's first cell, or where an empty column would begin.
int So3Grid::ColumnStart(size_t slot) const {
  const int place = static_cast<int>(slot);
  const int a = place / (k_ * k_);
  const int b = place / k_ % k_;
  const int c = place % k_;
  if (Square(a) + Square(b) + Square(c) > Square(k_)) return column_first_[slot];
  return column_first_[slot] + LowestInColumn(Square(a + 1) + Square(b + 1) + Square(c + 1));
}

// The last column that begins at or before a place in the octant. Columns without cells begin where
// the next one with cells does, so they are never the last.
size_t So3Grid::ColumnHolding(int place) const {
  size_t slot = 0;
  for (size_t step = std::bit_floor(column_first_.size()); step > 0; step /= 2) {
    if (slot + step < column_first_.size() && ColumnStart(slot + step) <= place) slot += step;
  }
  return slot;
}

void So3Grid::CellsAt(int32_t first, int32_t count, std::vector<Cell>* cells) const {
  VANTAGE_CHECK(first >= 0 && count >= 0 && count <= num_cells_ - first,
                Format("places %d + %d of %d", first, count, num_cells_));
  cells->clear();
  const int octant_size = num_cells_ / 8;
  const auto unreflected = [this](int lower, bool positive) {
    return positive ? lower + k_ : k_ - 1 - lower;
  };
  size_t slot = 0;
  int column_end = 0;  // Place in the octant; at most `place` where a new column must be found.
  for (int32_t ordinal = first; ordinal < first + count; ++ordinal) {
    const int octant = ordinal / octant_size;
    const int place = ordinal % octant_size;
    if (ordinal == first || place == 0) {
      slot = ColumnHolding(place);
      column_end = slot + 1 < column_first_.size() ? ColumnStart(slot + 1) : octant_size;
    }
    while (place >= column_end) {
      ++slot;
      column_end = slot + 1 < column_first_.size() ? ColumnStart(slot + 1) : octant_size;
    }
    const auto column = static_cast<int>(slot);
    cells->push_back(CellAt({unreflected(column / (k_ * k_), (octant & 4) != 0),
                             unreflected(column / k_ % k_, (octant & 2) != 0),
                             unreflected(column % k_, (octant & 1) != 0),
                             place - column_first_[slot]}));
  }
}

So3Grid::Cell So3Grid::CellOf(const Eigen::Quaterniond& q) const {
  // Rounding can't lead to an invalid cell: those stay 1 / k^2 clear of the sphere.
  const Eigen::Vector4d point = Canonical(q.normalized()).coeffs();
  Index index{};
  for (size_t i = 0; i < 3; ++i) {
    const double scaled = std::floor(point[static_cast<Eigen::Index>(i)] * k_);
    index[i] = std::clamp(static_cast<int>(scaled) + k_, 0, 2 * k_ - 1);
  }
  index[3] = std::clamp(static_cast<int>(std::floor(point[3] * k_)), 0, k_ - 1);
  return CellAt(index);
}

Eigen::Quaterniond So3Grid::Representative(Cell cell) const {
  const auto [ix, iy, iz, iw] = IndexOf(cell);
  const Column column = ColumnAt(ix, iy, iz);
  return Eigen::Quaterniond(Point(column, PatchIn(column, iw)).normalized());
}

double So3Grid::Area(Cell cell) const {
  const auto [ix, iy, iz, iw] = IndexOf(cell);
  return PatchIn(ColumnAt(ix, iy, iz), iw).patch->area;
}

void So3Grid::Neighbors(Cell cell, std::vector<Neighbor>* neighbors) const {
  neighbors->clear();
  const Index center = IndexOf(cell);
  const int last = 2 * k_ - 1;
  for (int code = 0; code < 81; ++code) {
    Index index = {center[0] + code / 27 - 1,
                   center[1] + code / 9 % 3 - 1,
                   center[2] + code / 3 % 3 - 1,
                   center[3] + code % 3 - 1};
    if (std::min({index[0], index[1], index[2]}) < 0 || index[3] >= k_) continue;
    if (std::max({index[0], index[1], index[2]}) > last) continue;
    // Below w = 0 lies the antipode of a cell above it.
    if (index[3] < 0) index = {last - index[0], last - index[1], last - index[2], 0};
    const Cell neighbor = CellAt(index);
    if (neighbor == cell || !MeetsSphere(index)) continue;
    neighbors->push_back({neighbor, OrdinalAt(index)});
  }
  // Only in the coarsest grids a cell is met both directly and across w = 0.
  if (k_ > 4) return;
  const auto by_cell = [](const Neighbor& a, const Neighbor& b) { return a.cell < b.cell; };
  const auto same = [](const Neighbor& a, const Neighbor& b) { return a.cell == b.cell; };
  std::sort(neighbors->begin(), neighbors->end(), by_cell);
  neighbors->erase(std::unique(neighbors->begin(), neighbors->end(), same), neighbors->end());
}

}  // namespace vantage
