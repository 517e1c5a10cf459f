#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <vector>

#include "fusion/so3_grid.h"

namespace vantage {

/// The confidence weights of one orientation on the cells of a grid, normalized: the density,
/// relative to the uniform one, of a probability distribution on SO(3).
class ConfidenceKernel {
 public:
  struct Cell {
    int32_t ordinal;
    double density;  ///< sum over the cells of density * area: 1
    double area;
    So3Grid::Cell cell;
  };

  /// @param grid outlives the kernel.
  explicit ConfidenceKernel(const So3Grid& grid) : grid_(&grid) {}

  /// Kernel about an orientation; valid until the next call. One too narrow for the grid to
  /// resolve is the orientation's own cell alone.
  /// @param sigma rad, > 0.
  std::span<const Cell> About(const Eigen::Quaterniond& q, double sigma);

 private:
  const So3Grid* grid_;
  std::vector<So3Grid::NearCell> near_;  // Reused.
  std::vector<Cell> cells_;
};

}  // namespace vantage
