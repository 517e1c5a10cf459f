#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <vector>

#include "common/result.h"

namespace vantage {

/// The histogram's cells on SO(3) (paper 4.2). x, y, z in [-1, 1] are divided into 2k parts and w
/// in [0, 1] into k; the cells that meet the unit sphere are valid: 8480, 68416, 548496 for k = 8,
/// 16, 32 (Table 1). Nothing is stored by cell: the distinct sphere patches are held (every valid
/// cell is one of them but for the order and signs of its coordinates; 3364 at k = 32), and where
/// each column of cells along w begins in one of the eight octants, which are all alike.
/// Immutable once made.
class So3Grid {
 public:
  static constexpr int kSmallest = 2;
  static constexpr int kLargest = 128;

  /// Number of a cell: its place ((ix * 2k + iy) * 2k + iz) * k + iw in the lattice.
  using Cell = int32_t;

  /// A cell whose representative lies near some orientation.
  struct NearCell {
    Cell cell;
    int32_t ordinal;       ///< Ordinal(cell)
    double squared_angle;  ///< rad^2, from the orientation to the representative
    double area;           ///< Area(cell)
  };

  struct Neighbor {
    Cell cell;
    int32_t ordinal;  ///< Ordinal(cell)
  };

  /// @param k in kSmallest..kLargest; checked. What comes from outside goes through Create.
  explicit So3Grid(int k);
  /// Error: k out of range.
  static Result<So3Grid> Create(int k);

  [[nodiscard]] int k() const { return k_; }
  /// N, the number of valid cells.
  [[nodiscard]] int num_cells() const { return num_cells_; }
  /// Size of all tables, bytes.
  [[nodiscard]] size_t bytes() const;
  /// True when the closed cell meets the unit sphere. False for numbers outside the lattice.
  [[nodiscard]] bool IsValid(Cell cell) const;
  /// All valid cells, ascending: O(k^3), for tables over the whole of SO(3).
  [[nodiscard]] std::vector<Cell> ValidCells() const;

  /// Place of a valid cell among all valid ones, 0..N-1, for storage without gaps. O(1).
  [[nodiscard]] int32_t Ordinal(Cell cell) const;
  /// The valid cells at the places `first` to `first + count - 1`: the inverse of Ordinal.
  /// O(log k + count).
  void CellsAt(int32_t first, int32_t count, std::vector<Cell>* cells) const;

  /// The cell that holds an orientation, always a valid one; the same for q and -q. O(1).
  [[nodiscard]] Cell CellOf(const Eigen::Quaterniond& q) const;
  /// q_r: the normalized centroid of the sphere patch inside a valid cell.
  [[nodiscard]] Eigen::Quaterniond Representative(Cell cell) const;
  /// w_I of the uniform prior: the patch's share of SO(3). Sums to 1 over the valid cells; 0 for
  /// the few cells that touch the sphere in a point.
  [[nodiscard]] double Area(Cell cell) const;
  /// Valid cells among the 3^4 - 1 around a valid cell, across w = 0 too, each once.
  void Neighbors(Cell cell, std::vector<Neighbor>* neighbors) const;
  /// Cells whose representative lies within `radius` (rad) of q, each once, in an order that is the
  /// same for q and -q. The cost is that of the cells found.
  void CellsWithin(const Eigen::Quaterniond& q, double radius, std::vector<NearCell>* cells) const;

 private:
  using Index = std::array<int, 4>;  // Place in the lattice along x, y, z, w.

  // The cells that differ in w alone, seen from the positive orthant.
  struct Column {
    std::array<int, 3> lower;   // Corner nearest to 0 along x, y, z, in cells.
    std::array<int, 3> sorted;  // The same, ascending,
    std::array<int, 3> axis;    // and which axis each is of.
    std::array<double, 3> sign;
    int nearest;   // Squared distance of that corner to the w axis,
    int farthest;  // and of the opposite one.
  };
  // A sphere patch as it is stored; single precision places the centroid within 1e-5 degrees.
  struct Patch {
    double area;
    std::array<float, 4> centroid;
  };
  // A patch of a column's cell, and which of its coordinates is along w.
  struct Placed {
    const Patch* patch;
    int rank_of_w;
  };

  [[nodiscard]] Index IndexOf(Cell cell) const;
  [[nodiscard]] Cell CellAt(const Index& index) const {
    return ((index[0] * 2 * k_ + index[1]) * 2 * k_ + index[2]) * k_ + index[3];
  }
  [[nodiscard]] int32_t OrdinalAt(const Index& index) const;
  [[nodiscard]] Column ColumnAt(int ix, int iy, int iz) const;
  // Lowest iw with (iw + 1)^2 >= k^2 - farthest.
  [[nodiscard]] int LowestInColumn(int farthest) const {
    return farthest >= k_ * k_ ? 0 : lowest_[static_cast<size_t>(k_ * k_ - farthest)];
  }
  [[nodiscard]] bool MeetsSphere(const Index& index) const;
  [[nodiscard]] int ReflectedLower(int i) const { return i >= k_ ? i - k_ : k_ - 1 - i; }
  [[nodiscard]] size_t ColumnSlot(int a, int b, int c) const {
    return static_cast<size_t>((a * k_ + b) * k_ + c);
  }
  // Place of the first cell of the octant that a column lies in.
  [[nodiscard]] int OctantFirst(int ix, int iy, int iz) const {
    const int octant = (ix >= k_ ? 4 : 0) + (iy >= k_ ? 2 : 0) + (iz >= k_ ? 1 : 0);
    return octant * (num_cells_ / 8);
  }
  [[nodiscard]] int ColumnStart(size_t slot) const;
  [[nodiscard]] size_t ColumnHolding(int place) const;
  [[nodiscard]] Placed PatchIn(const Column& column, int iw) const;
  static Eigen::Vector4d Point(const Column& column, const Placed& placed);
  struct Cap;
  struct Axis;
  struct Match;
  [[nodiscard]] Match Compare(const std::array<Axis, 4>& sorted) const;
  struct Output;
  void AppendRow(const Cap& cap, int x, int y, double rest, Output* output) const;
  void AppendCellsNear(const Cap& cap, Output* output) const;
  void KeepNearerHalf(const Eigen::Vector4d& q,
                      size_t num_here,
                      std::vector<NearCell>* cells) const;
  // Place in first_patch_ of a <= b <= c.
  [[nodiscard]] size_t TripleSlot(int a, int b, int c) const {
    return static_cast<size_t>(tetrahedral_[static_cast<size_t>(c)] + b * (b + 1) / 2 + a);
  }

  int k_;
  int num_cells_ = 0;
  std::vector<int32_t> tetrahedral_;   // By c: triples a <= b <= c' with c' < c.
  std::vector<int16_t> lowest_;        // By k^2 less the farthest corner's squared distance.
  std::vector<int32_t> column_first_;  // By ColumnSlot: place in the octant, less the lowest w.
  std::vector<int32_t> first_patch_;   // By the three smallest coordinates; plus the largest one.
  std::vector<Patch> patches_;
};

}  // namespace vantage
