#include "fusion/so3_grid.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "common/check.h"
#include "common/format.h"
#include "common/so3.h"

namespace vantage {
namespace {

int Square(int value) { return value * value; }

// Place of a <= b <= c among all such triples.
size_t TripleIndex(int a, int b, int c) {
  return static_cast<size_t>(c * (c + 1) * (c + 2) / 6 + b * (b + 1) / 2 + a);
}

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

// Range of cells along one axis that a coordinate in cos([angle - radius, angle + radius]) meets.
std::pair<int, int> CellRange(double coordinate, double radius, int k, int lowest, int highest) {
  const double angle = std::acos(std::clamp(coordinate, -1.0, 1.0));
  const double low = std::cos(std::min(std::numbers::pi, angle + radius));
  const double high = std::cos(std::max(0.0, angle - radius));
  constexpr double kRounding = 1e-9;
  return {std::max(lowest, static_cast<int>(std::floor(low * k - kRounding))),
          std::min(highest, static_cast<int>(std::floor(high * k + kRounding)))};
}

}  // namespace

So3Grid::So3Grid(int k) : k_(k) {
  VANTAGE_CHECK(k >= kSmallest && k <= kLargest, Format("k = %d, expected 2..128", k));
  first_patch_.resize(TripleIndex(0, 0, k), 0);
  for (int c = 0; c < k; ++c) {
    for (int b = 0; b <= c; ++b) {
      for (int a = 0; a <= b; ++a) {
        bool first = true;
        for (int d = c; d < k; ++d) {
          const Index lower = {a, b, c, d};
          if (!MeetsSphere(lower)) continue;
          if (first) {
            first_patch_[TripleIndex(a, b, c)] = static_cast<int32_t>(patches_.size()) - d;
            first = false;
          }
          patches_.push_back(IntegrateSpherePatch(lower, k));
          num_cells_ += 8 * NumPermutations(lower);  // 8: the signs of x, y, z.
        }
      }
    }
  }
}

So3Grid::Index So3Grid::IndexOf(Cell cell) const {
  const int iw = cell % k_;
  const int xyz = cell / k_;
  return {xyz / (4 * k_ * k_), xyz / (2 * k_) % (2 * k_), xyz % (2 * k_), iw};
}

So3Grid::Cell So3Grid::CellAt(const Index& index) const {
  return ((index[0] * 2 * k_ + index[1]) * 2 * k_ + index[2]) * k_ + index[3];
}

// The corner nearest to 0 after reflection into the positive orthant, in cells.
So3Grid::Index So3Grid::LowerCorner(const Index& index) const {
  const auto reflected = [this](int i) { return i >= k_ ? i - k_ : k_ - 1 - i; };
  return {reflected(index[0]), reflected(index[1]), reflected(index[2]), index[3]};
}

bool So3Grid::MeetsSphere(const Index& lower) const {
  int nearest = 0;
  int farthest = 0;
  for (const int i : lower) {
    nearest += Square(i);
    farthest += Square(i + 1);
  }
  return nearest <= Square(k_) && Square(k_) <= farthest;
}

bool So3Grid::IsValid(Cell cell) const {
  const int64_t lattice = int64_t{8} * k_ * k_ * k_ * k_;
  return cell >= 0 && cell < lattice && MeetsSphere(LowerCorner(IndexOf(cell)));
}

std::vector<So3Grid::Cell> So3Grid::ValidCells() const {
  std::vector<Cell> cells;
  cells.reserve(static_cast<size_t>(num_cells_));
  for (int ix = 0; ix < 2 * k_; ++ix) {
    for (int iy = 0; iy < 2 * k_; ++iy) {
      for (int iz = 0; iz < 2 * k_; ++iz) {
        for (int iw = 0; iw < k_; ++iw) {
          const Index index = {ix, iy, iz, iw};
          if (MeetsSphere(LowerCorner(index))) cells.push_back(CellAt(index));
        }
      }
    }
  }
  return cells;
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

const SpherePatch& So3Grid::PatchOf(const Index& sorted_lower) const {
  const int32_t first =
      first_patch_[TripleIndex(sorted_lower[0], sorted_lower[1], sorted_lower[2])];
  return patches_[static_cast<size_t>(first + sorted_lower[3])];
}

Eigen::Vector4d So3Grid::RepresentativeAt(const Index& index) const {
  const Index lower = LowerCorner(index);
  std::array<int, 4> order = {0, 1, 2, 3};
  const auto sort_pair = [&](size_t i, size_t j) {
    if (lower[static_cast<size_t>(order[i])] > lower[static_cast<size_t>(order[j])]) {
      std::swap(order[i], order[j]);
    }
  };
  sort_pair(0, 1);
  sort_pair(2, 3);
  sort_pair(0, 2);
  sort_pair(1, 3);
  sort_pair(1, 2);
  Index sorted{};
  for (size_t i = 0; i < 4; ++i) sorted[i] = lower[static_cast<size_t>(order[i])];
  const SpherePatch& patch = PatchOf(sorted);
  Eigen::Vector4d point;
  for (size_t i = 0; i < 4; ++i) {
    const int axis = order[i];
    const bool negative = axis != 3 && index[static_cast<size_t>(axis)] < k_;
    const double coordinate = patch.centroid[static_cast<Eigen::Index>(i)];
    point[axis] = negative ? -coordinate : coordinate;
  }
  return point;
}

Eigen::Quaterniond So3Grid::Representative(Cell cell) const {
  return Eigen::Quaterniond(RepresentativeAt(IndexOf(cell)));
}

double So3Grid::Area(Cell cell) const {
  Index lower = LowerCorner(IndexOf(cell));
  std::sort(lower.begin(), lower.end());
  return PatchOf(lower).area;
}

void So3Grid::Neighbors(Cell cell, std::vector<Cell>* neighbors) const {
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
    if (neighbor != cell && MeetsSphere(LowerCorner(index))) neighbors->push_back(neighbor);
  }
  std::sort(neighbors->begin(), neighbors->end());
  neighbors->erase(std::unique(neighbors->begin(), neighbors->end()), neighbors->end());
}

void So3Grid::CellsWithin(const Eigen::Quaterniond& q,
                          double radius,
                          std::vector<NearCell>* cells) const {
  cells->clear();
  const Eigen::Vector4d point = Canonical(q.normalized()).coeffs();
  AppendCellsNear(point, radius, true, cells);
  const size_t num_here = cells->size();
  AppendCellsNear(-point, radius, false, cells);
  if (num_here != cells->size()) {
    std::inplace_merge(cells->begin(),
                       cells->begin() + static_cast<std::ptrdiff_t>(num_here),
                       cells->end(),
                       [](const NearCell& a, const NearCell& b) { return a.cell < b.cell; });
  }
}

// Walks the part of the lattice in the bounding box of the cap about q on the half sphere w >= 0.
// Of w only the layers that meet the sphere are visited. Representatives at 90 degrees on the
// sphere from q are as near to -q; they are kept in one of the two calls.
void So3Grid::AppendCellsNear(const Eigen::Vector4d& q,
                              double radius,
                              bool keep_equator,
                              std::vector<NearCell>* cells) const {
  const double cap = 0.5 * radius;  // An angle on SO(3) is twice that on S^3.
  const auto [x_first, x_last] = CellRange(q[0], cap, k_, -k_, k_ - 1);
  const auto [y_first, y_last] = CellRange(q[1], cap, k_, -k_, k_ - 1);
  const auto [z_first, z_last] = CellRange(q[2], cap, k_, -k_, k_ - 1);
  const auto [w_first, w_last] = CellRange(q[3], cap, k_, 0, k_ - 1);
  for (int x = x_first; x <= x_last; ++x) {
    for (int y = y_first; y <= y_last; ++y) {
      for (int z = z_first; z <= z_last; ++z) {
        const Index above = LowerCorner({x + k_, y + k_, z + k_, 0});
        const int nearest = Square(above[0]) + Square(above[1]) + Square(above[2]);
        if (nearest > Square(k_)) continue;
        const int farthest = Square(above[0] + 1) + Square(above[1] + 1) + Square(above[2] + 1);
        // Layers iw with iw^2 <= k^2 - nearest and (iw + 1)^2 >= k^2 - farthest.
        const int highest =
            std::min(w_last, static_cast<int>(std::sqrt(Square(k_) - nearest + 0.5)));
        int iw = w_first;
        if (farthest < Square(k_)) {
          const double layer = std::ceil(std::sqrt(Square(k_) - farthest - 0.5)) - 1.0;
          iw = std::max(iw, static_cast<int>(layer));
        }
        for (; iw <= highest; ++iw) {
          const Index index = {x + k_, y + k_, z + k_, iw};
          const Eigen::Vector4d point = RepresentativeAt(index);
          const double dot = point.dot(q);
          if (dot < 0.0 || (dot == 0.0 && !keep_equator)) continue;
          const double angle = 4.0 * std::asin(std::min(1.0, 0.5 * (point - q).norm()));
          if (angle <= radius) cells->push_back({CellAt(index), angle});
        }
      }
    }
  }
}

}  // namespace vantage
