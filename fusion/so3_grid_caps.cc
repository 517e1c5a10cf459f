// The walk over the cells near an orientation.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "common/so3.h"
#include "fusion/so3_grid.h"

namespace vantage {
namespace {

int Square(int value) { return value * value; }
double Square(double value) { return value * value; }

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

// The part of SO(3) about an orientation, on one side of S^3.
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
