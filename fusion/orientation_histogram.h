#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <span>
#include <vector>

#include "fusion/cell_weights.h"
#include "fusion/confidence_kernel.h"
#include "fusion/orientation_prior.h"
#include "fusion/so3_grid.h"

namespace vantage {

/// Weights w_r on the cells of SO(3) (paper section 5), kept for the cells that detections touched.
///
/// Detections are added, not multiplied (eq. 3): either of them may be wrong. A detection's
/// confidence weights are normalized so that its mass, the sum of w_r times the cell's area, is w_v
/// whatever the shapes of the cells near it: w_r is a density relative to the uniform one. With a
/// prior, w_r is that times the prior's density.
class OrientationHistogram {
 public:
  /// @param grid outlives the histogram. @param prior of the same grid.
  explicit OrientationHistogram(const So3Grid& grid, OrientationPrior prior = {});

  /// One step of equation 5: adds the truncated confidence weights (eq. 2) of a detected
  /// orientation, normalized, times its verification weight. Costs the cells touched.
  /// @param q of norm 1. @param sigma_cw rad, > 0. Narrower than the grid, it votes for the
  /// detection's own cell. @param verification_weight w_v (eq. 4), >= 0, finite.
  void Add(const Eigen::Quaterniond& q, double sigma_cw, double verification_weight);
  /// A vote of weight w_v for the detection's own cell, whatever its area (5.2, "voting").
  void Vote(const Eigen::Quaterniond& q, double verification_weight);

  /// What is added to one cell.
  struct Addend {
    int32_t ordinal;  ///< So3Grid::Ordinal
    double density;   ///< relative to the uniform one, >= 0
    double area;
  };
  /// Adds a density that is `everywhere` but for some cells, which have `cells` on top. Costs those
  /// cells.
  void AddDensity(std::span<const Addend> cells, double everywhere);

  /// w_r of the cells beyond what is everywhere().
  [[nodiscard]] const CellWeights& weights() const { return weights_; }
  /// What AddDensity added everywhere, relative to the prior. It moves no peak, so neither
  /// weights() nor Entropy() have it.
  [[nodiscard]] double everywhere() const { return everywhere_; }
  /// w_r of a cell; 0 where nothing was added.
  [[nodiscard]] double Weight(So3Grid::Cell cell) const;
  [[nodiscard]] bool empty() const { return mass_ <= 0.0; }
  /// Sum of w_r times the area over all cells: with a uniform prior and no votes the sum of the
  /// verification weights added.
  [[nodiscard]] double Mass() const { return mass_; }
  /// Entropy of the cells' shares of the mass beyond what is everywhere(), nat; 0 when a single
  /// cell has it all, or none.
  [[nodiscard]] double Entropy() const;
  [[nodiscard]] const So3Grid& grid() const { return weights_.grid(); }

 private:
  OrientationPrior prior_;
  CellWeights weights_;
  ConfidenceKernel kernel_;
  double mass_ = 0.0;
  double everywhere_ = 0.0;
};

}  // namespace vantage
