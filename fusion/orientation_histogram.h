#pragma once

#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "fusion/so3_grid.h"

namespace vantage {

/// Weights w_r on the cells of SO(3) (paper section 5), kept for the cells that detections touched.
///
/// Detections are added, not multiplied (eq. 3): either of them may be wrong. A detection's
/// confidence weights are normalized so that its mass, the sum of w_r times the prior w_I (eq. 6),
/// is w_v whatever the shapes of the cells near it: w_r is a density relative to the uniform one.
class OrientationHistogram {
 public:
  struct Entry {
    So3Grid::Cell cell;
    double weight;  ///< w_r

    bool operator==(const Entry&) const = default;
  };

  /// @param grid outlives the histogram.
  explicit OrientationHistogram(const So3Grid& grid) : grid_(&grid) {}

  /// One step of equation 5: adds the truncated confidence weights (eq. 2) of a detected
  /// orientation, normalized, times its verification weight. Costs the cells touched.
  /// @param sigma_cw rad, > 0. Narrower than the grid, it votes for the detection's own cell.
  /// @param verification_weight w_v (eq. 4), >= 0.
  void Add(const Eigen::Quaterniond& q, double sigma_cw, double verification_weight);

  /// Cells with weight, ascending.
  [[nodiscard]] std::span<const Entry> entries() const { return entries_; }
  /// w_r of a cell; 0 where nothing was added.
  [[nodiscard]] double Weight(So3Grid::Cell cell) const;
  /// Place of a cell in entries(), or -1.
  [[nodiscard]] int Find(So3Grid::Cell cell) const;
  [[nodiscard]] bool empty() const { return entries_.empty(); }
  /// Sum of w_r w_I over all cells: the sum of the verification weights added.
  [[nodiscard]] double Mass() const;
  /// Entropy of the cells' shares of the mass, nat; 0 when a single cell has it all, or none.
  [[nodiscard]] double Entropy() const;
  [[nodiscard]] const So3Grid& grid() const { return *grid_; }

 private:
  void Merge(std::span<const Entry> added);

  const So3Grid* grid_;
  std::vector<Entry> entries_;
  std::vector<So3Grid::NearCell> near_;  // Reused by Add.
  std::vector<Entry> added_;
  std::vector<Entry> merged_;
};

}  // namespace vantage
