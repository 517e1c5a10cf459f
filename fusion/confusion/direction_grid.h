#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/rng.h"

namespace vantage {

/// Cells of equal area and nearly equal shape on the sphere of viewing directions: rings between
/// circles of latitude, each divided evenly by longitude, a cap at each pole (the zonal partition
/// of Leopardi, "A partition of the unit sphere into regions of equal area and small diameter",
/// ETNA 2006). Immutable once made.
class DirectionGrid {
 public:
  static constexpr int kFewest = 2;
  static constexpr int kMost = 100'000;

  /// @param num_cells in kFewest..kMost; checked.
  explicit DirectionGrid(int num_cells);

  [[nodiscard]] int num_cells() const { return num_cells_; }
  /// The cell that holds a direction, of any length above 0. O(1).
  [[nodiscard]] int CellOf(const Eigen::Vector3d& direction) const;
  /// A unit vector in the middle of a cell.
  [[nodiscard]] Eigen::Vector3d Center(int cell) const;
  /// Uniform over a cell; a unit vector.
  [[nodiscard]] Eigen::Vector3d Sample(int cell, Rng& rng) const;
  /// Cells whose center lies within `radius` rad of a direction, ascending.
  [[nodiscard]] std::vector<int> CellsWithin(const Eigen::Vector3d& direction, double radius) const;

 private:
  // Between two circles of latitude. Those above it hold `first` cells: its borders follow.
  struct Ring {
    int first = 0;  // Cell.
    int count = 1;
    double colatitude = 0.0;  // Of its cells' centers, rad.
  };
  [[nodiscard]] const Ring& RingOf(int cell) const;

  int num_cells_;
  std::vector<Ring> rings_;        // From z = 1 down.
  std::vector<int> ring_of_cell_;  // Place in rings_.
};

/// Number of cells as large as the square of the angle between nearest neighbors of the orientation
/// grid of this k (paper Table 1: 10.28 deg at k = 8, and in proportion): 391 at k = 8, 6,246 at
/// k = 32.
int NumDirections(int k);

}  // namespace vantage
