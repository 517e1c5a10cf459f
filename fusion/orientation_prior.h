#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <span>
#include <vector>

#include "common/result.h"
#include "fusion/cell_weights.h"
#include "fusion/so3_grid.h"

namespace vantage {

/// An orientation that an object is often found in.
struct LikelyPose {
  Eigen::Quaterniond q_world_object = Eigen::Quaterniond::Identity();
  double spread = 0.0;  ///< rad, > 0, standard deviation about it, in each of three axes
  double weight = 1.0;  ///< >= 0, how often in comparison with the others
};

/// What is known of an object's orientation before it is seen (paper 4.2): any distribution that
/// the grid can represent, as a density relative to the uniform one. w_I of equation 6 is this
/// density times the cell's area. Copies share their storage.
class OrientationPrior {
 public:
  /// Uniform: the same density everywhere, whatever the grid.
  OrientationPrior() = default;

  /// A share of the mass spread evenly over SO(3), the rest around likely poses.
  /// @param uniform_share [0, 1]. Where it is 0, orientations far from all poses are impossible.
  /// Errors: a pose that is no orientation, a spread or weight out of range, no mass at all.
  static Result<OrientationPrior> AroundPoses(const So3Grid& grid,
                                              std::span<const LikelyPose> poses,
                                              double uniform_share);
  /// A weight for each cell that is listed and one for all others, in proportion to the density.
  /// Errors: a cell that is not valid or listed twice, a weight that is negative or not finite, no
  /// mass at all.
  static Result<OrientationPrior> OnCells(const So3Grid& grid,
                                          std::span<const CellWeights::Entry> cells,
                                          double weight_elsewhere);

  [[nodiscard]] bool is_uniform() const { return cells_ == nullptr; }
  /// Density of the cell at a place (So3Grid::Ordinal), relative to the uniform one; its mean over
  /// SO(3) is 1.
  [[nodiscard]] double Density(int32_t ordinal) const {
    if (cells_ == nullptr) return 1.0;
    return elsewhere_ + static_cast<double>(cells_->At(ordinal));
  }
  /// Density of the cells that are not listed or lie far from all poses.
  [[nodiscard]] double density_elsewhere() const { return elsewhere_; }
  /// The cells of another density, ascending, and how much theirs is above it.
  [[nodiscard]] std::vector<CellWeights::Entry> AboveElsewhere() const {
    return cells_ == nullptr ? std::vector<CellWeights::Entry>{} : cells_->Entries();
  }

 private:
  static Result<OrientationPrior> Normalized(CellWeights cells, double mass, double elsewhere);

  std::shared_ptr<const CellWeights> cells_;  // Above elsewhere_; null: uniform.
  double elsewhere_ = 1.0;
};

}  // namespace vantage
