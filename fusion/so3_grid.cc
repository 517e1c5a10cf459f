#include "fusion/so3_grid.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <utility>

#include "common/check.h"
#include "common/format.h"
#include "common/so3.h"
#include "fusion/sphere_patch.h"

namespace vantage {
namespace {

int Square(int value) { return value * value; }
double Square(double value) { return value * value; }

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

// Squared angle on SO(3) from the squared length of the chord on S^3: (4 asin(c / 2))^2, by its
// power series as far as that is exact to rounding.
double SquaredAngle(double squared_chord) {
  const double u = squared_chord;
  constexpr double kTo4 = 1.0 / 1120;
  if (u < 0.01) {
    return 8.0 * u * (1.0 / 2 + u * (1.0 / 24 + u * (1.0 / 180 + u * (kTo4 + u * (1.0 / 6300)))));
  }
  if (u > 0.1) return Square(4.0 * std::asin(std::min(1.0, 0.5 * std::sqrt(u))));
  const double from_5 = 1.0 / 6300 + u * (1.0 / 33264 + u * (1.0 / 168168 + u / 823680));
  return 8.0 * u * (1.0 / 2 + u * (1.0 / 24 + u * (1.0 / 180 + u * (kTo4 + u * from_5))));
}

// std::floor is a library call on processors without SSE 4.1.
int Floor(double value) {
  const int truncated = static_cast<int>(value);
  return truncated - (value < truncated ? 1 : 0);
}

// Cells along one axis that come within `reach` of a coordinate; both in cells.
struct CellRange {
  int first;
  int last;
};
CellRange Within(double coordinate, double reach, int lowest, int highest) {
  return {std::max(lowest, Floor(coordinate - reach)),
          std::min(highest, Floor(coordinate + reach))};
}

// Distance of a coordinate from the cell [i, i + 1].
double DistanceToCell(double coordinate, int i) {
  return std::max(0.0, std::max(i - coordinate, coordinate - (i + 1)));
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

// The part of SO(3) about an orientation, on one side of S^3, and the cells found in it so far.
struct So3Grid::Cap {
  Cap(const Eigen::Vector4d& center, double squared_chord_to_rim, int k)
      : q(center),
        squared_chord(squared_chord_to_rim),
        // A representative may lie outside of its cell, by the height of the sphere over the patch.
        reach(std::sqrt(squared_chord) * k + 0.5 / k + 1e-9),
        layers(Within(q[3] * k, reach, 0, k - 1)) {
    for (int iw = layers.first; iw <= layers.last; ++iw) {
      layer_distance[static_cast<size_t>(iw)] = Square(DistanceToCell(q[3] * k, iw));
    }
  }

  Eigen::Vector4d q;
  double squared_chord;                         // From its center to its rim.
  double reach;                                 // The same in cells.
  CellRange layers;                             // Cells along w within reach.
  std::array<double, kLargest> layer_distance;  // Squared, of these.
};

// Cells under way to the caller's vector, written without asking its size each time.
struct So3Grid::Output {
  explicit Output(std::vector<NearCell>* target) : cells(target) { Grow(0); }

  void Grow(size_t num_kept) {
    cells->resize(2 * num_kept + 256);
    next = cells->data() + num_kept;
    end = cells->data() + cells->size();
  }
  [[nodiscard]] size_t num_kept() const { return static_cast<size_t>(next - cells->data()); }

  std::vector<NearCell>* cells;
  NearCell* next = nullptr;
  NearCell* end = nullptr;
};

void So3Grid::CellsWithin(const Eigen::Quaterniond& q,
                          double radius,
                          std::vector<NearCell>* cells) const {
  const Eigen::Vector4d point = Canonical(q.normalized()).coeffs();
  // An angle on SO(3) is twice that on S^3.
  const double angle = 0.5 * std::min(radius, std::numbers::pi);
  const double squared_chord = Square(2.0 * std::sin(0.5 * angle)) * (1.0 + 1e-7);
  Output output(cells);
  AppendCellsNear(Cap(point, squared_chord, k_), &output);
  // The cap about -q reaches the half sphere w >= 0 only if q is near its rim.
  const size_t num_here = output.num_kept();
  if (point[3] <= std::sin(angle) + 2.0 / k_) {
    AppendCellsNear(Cap(-point, squared_chord, k_), &output);
  }
  cells->resize(output.num_kept());
  // Only so large a cap holds representatives that are nearer to the other one of q and -q.
  if (squared_chord > 1.9) KeepNearerHalf(point, num_here, cells);
  for (NearCell& cell : *cells) cell.squared_angle = SquaredAngle(cell.squared_angle);
}

// Drops what lies beyond 90 degrees on S^3 from the center that it was found from: q for the first
// num_here cells, -q for the others. What lies at 90 degrees stays with q.
void So3Grid::KeepNearerHalf(const Eigen::Vector4d& q,
                             size_t num_here,
                             std::vector<NearCell>* cells) const {
  size_t num_kept = 0;
  for (size_t i = 0; i < cells->size(); ++i) {
    const double dot = Representative((*cells)[i].cell).coeffs().dot(q);
    if (i < num_here ? dot >= 0.0 : dot < 0.0) (*cells)[num_kept++] = (*cells)[i];
  }
  cells->resize(num_kept);
}

// A coordinate of a cell's lower corner, reflected into the positive orthant, and the same
// coordinate of a cap's center.
struct So3Grid::Axis {
  int lower;
  double q;
};

namespace {

// Orders two axes without a branch.
template <class Axis>
void Sort(Axis& i, Axis& j) {
  const bool swaps = i.lower > j.lower;
  const Axis low = {swaps ? j.lower : i.lower, swaps ? j.q : i.q};
  j = {swaps ? i.lower : j.lower, swaps ? i.q : j.q};
  i = low;
}

}  // namespace

// Of a representative and a cap's center.
struct So3Grid::Match {
  double squared_chord;
  double area;
};

inline So3Grid::Match So3Grid::Compare(const std::array<Axis, 4>& sorted) const {
  const size_t triple = TripleSlot(sorted[0].lower, sorted[1].lower, sorted[2].lower);
  const Patch& patch = patches_[static_cast<size_t>(first_patch_[triple] + sorted[3].lower)];
  const auto squared_difference = [&](size_t i) {
    return Square(static_cast<double>(patch.centroid[i]) - sorted[i].q);
  };
  return {(squared_difference(0) + squared_difference(1)) +
              (squared_difference(2) + squared_difference(3)),
          patch.area};
}

// The cells at one x and y whose squared distance along z and w, in cells, is at most `rest`. They
// are reflected into the positive orthant and their coordinates put into ascending order, as those
// of the patches are; the cap's center goes the same way. A cell is written first and kept by
// moving on, since which one is kept can't be foreseen: squared_angle holds the squared chord.
void So3Grid::AppendRow(const Cap& cap, int x, int y, double rest, Output* output) const {
  const double center_z = cap.q[2] * k_;
  const CellRange zs = Within(center_z, std::sqrt(rest), -k_, k_ - 1);
  Axis low = {ReflectedLower(x + k_), x >= 0 ? cap.q[0] : -cap.q[0]};
  Axis high = {ReflectedLower(y + k_), y >= 0 ? cap.q[1] : -cap.q[1]};
  const size_t slot_xy = ColumnSlot(low.lower, high.lower, 0);
  const int nearest_xy = Square(low.lower) + Square(high.lower);
  const Cell first_cell_xy = CellAt({x + k_, y + k_, k_, 0});
  const int32_t octant_below = OctantFirst(x + k_, y + k_, 0);
  const int32_t octant_above = OctantFirst(x + k_, y + k_, k_);
  Sort(low, high);
  for (int z = zs.first; z <= zs.last; ++z) {
    const double rest_w = rest - Square(DistanceToCell(center_z, z));
    Axis c = {z >= 0 ? z : -1 - z, z >= 0 ? cap.q[2] : -cap.q[2]};
    const int nearest = nearest_xy + Square(c.lower);
    if (rest_w < 0.0 || nearest > Square(k_)) continue;
    const Cell first_cell = first_cell_xy + z * k_;
    const int32_t first_place = (z >= 0 ? octant_above : octant_below) +
                                column_first_[slot_xy + static_cast<size_t>(c.lower)];
    Axis a = low;
    Axis b = high;
    Sort(b, c);
    Sort(a, b);
    const auto w = [&cap](int lower) { return Axis{lower, cap.q[3]}; };
    const int lowest = LowestInColumn(nearest + 2 * (a.lower + b.lower + c.lower) + 3);
    for (int iw = std::max(lowest, cap.layers.first); iw <= cap.layers.last; ++iw) {
      if (nearest + Square(iw) > Square(k_)) break;
      if (cap.layer_distance[static_cast<size_t>(iw)] > rest_w) continue;
      // w takes its place among the others; nearly always the same one within a cap.
      const Match match = iw >= c.lower   ? Compare({a, b, c, w(iw)})
                          : iw >= b.lower ? Compare({a, b, w(iw), c})
                          : iw >= a.lower ? Compare({a, w(iw), b, c})
                                          : Compare({w(iw), a, b, c});
      if (output->next == output->end) output->Grow(output->num_kept());
      *output->next = {first_cell + iw, first_place + iw, match.squared_chord, match.area};
      output->next += match.squared_chord <= cap.squared_chord ? 1 : 0;
    }
  }
}

// Walks the cells, on the half sphere w >= 0, that come within the cap's chord of its center. Axis
// after axis the reach shrinks by what the axes before have used up.
void So3Grid::AppendCellsNear(const Cap& cap, Output* output) const {
  const Eigen::Vector4d center = cap.q * k_;
  const CellRange xs = Within(center[0], cap.reach, -k_, k_ - 1);
  for (int x = xs.first; x <= xs.last; ++x) {
    const double rest_x = Square(cap.reach) - Square(DistanceToCell(center[0], x));
    if (rest_x < 0.0) continue;
    const CellRange ys = Within(center[1], std::sqrt(rest_x), -k_, k_ - 1);
    for (int y = ys.first; y <= ys.last; ++y) {
      const double rest_y = rest_x - Square(DistanceToCell(center[1], y));
      if (rest_y >= 0.0) AppendRow(cap, x, y, rest_y, output);
    }
  }
}

}  // namespace vantage
