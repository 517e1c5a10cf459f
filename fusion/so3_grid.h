#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <vector>

#include "fusion/sphere_patch.h"

namespace vantage {

/// The histogram's cells on SO(3) (paper 4.2). x, y, z in [-1, 1] are divided into 2k parts and w
/// in [0, 1] into k; the cells that meet the unit sphere are valid: 8480, 68416, 548496 for k = 8,
/// 16, 32 (Table 1). Holds the distinct sphere patches only (every valid cell is one of them but
/// for the order and signs of its coordinates): 3364 of them at k = 32, 48 bytes each.
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
    double angle;  ///< rad, from the orientation to the representative
  };

  /// @param k in kSmallest..kLargest; checked.
  explicit So3Grid(int k);

  [[nodiscard]] int k() const { return k_; }
  /// N, the number of valid cells.
  [[nodiscard]] int num_cells() const { return num_cells_; }
  /// True when the closed cell meets the unit sphere. False for numbers outside the lattice.
  [[nodiscard]] bool IsValid(Cell cell) const;
  /// All valid cells, ascending: O(k^3), for tables over the whole of SO(3).
  [[nodiscard]] std::vector<Cell> ValidCells() const;

  /// The cell that holds an orientation, always a valid one; the same for q and -q. O(1).
  [[nodiscard]] Cell CellOf(const Eigen::Quaterniond& q) const;
  /// q_r: the normalized centroid of the sphere patch inside a valid cell.
  [[nodiscard]] Eigen::Quaterniond Representative(Cell cell) const;
  /// w_I of the uniform prior: the patch's share of SO(3). Sums to 1 over the valid cells; 0 for
  /// the few cells that touch the sphere in a point.
  [[nodiscard]] double Area(Cell cell) const;
  /// Valid cells among the 3^4 - 1 around a valid cell, across w = 0 too, ascending.
  void Neighbors(Cell cell, std::vector<Cell>* neighbors) const;
  /// Cells whose representative lies within `radius` (rad) of q, ascending. The cost is that of
  /// the cells found.
  void CellsWithin(const Eigen::Quaterniond& q, double radius, std::vector<NearCell>* cells) const;

 private:
  using Index = std::array<int, 4>;  // Place in the lattice along x, y, z, w.

  [[nodiscard]] Index IndexOf(Cell cell) const;
  [[nodiscard]] Cell CellAt(const Index& index) const;
  [[nodiscard]] Index LowerCorner(const Index& index) const;
  [[nodiscard]] bool MeetsSphere(const Index& lower) const;
  [[nodiscard]] const SpherePatch& PatchOf(const Index& sorted_lower) const;
  [[nodiscard]] Eigen::Vector4d RepresentativeAt(const Index& index) const;
  void AppendCellsNear(const Eigen::Vector4d& q,
                       double radius,
                       bool keep_equator,
                       std::vector<NearCell>* cells) const;

  int k_;
  int num_cells_ = 0;
  std::vector<int32_t> first_patch_;  // By the three smallest coordinates; plus the largest one.
  std::vector<SpherePatch> patches_;
};

}  // namespace vantage
