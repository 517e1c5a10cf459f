#pragma once

#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "common/result.h"
#include "common/so3.h"
#include "common/symmetry_group.h"
#include "fusion/confusion/contingency_table.h"
#include "fusion/confusion/direction_grid.h"

namespace vantage {

struct ConfusionModelParameters {
  double mode_radius = 6.0 * kDegree;  ///< rad, difference rotations that near are one mode
  /// Share of detections that may be anywhere: what was never seen in so many trials may yet
  /// happen.
  double outlier_share = 0.02;
  /// rad, of the Gaussian by which neighboring directions lend each other their trials.
  double direction_smoothing = 5.0 * kDegree;

  Result<void> Validate() const;
};

/// A contingency table made ready for fusion and planning: the difference rotations q_GT* q_D that
/// occur, as a few modes, and the share of each by viewing direction: P(q_D | q_GT) =
/// K_v(q_GT* q_D) with v the viewing direction of q_GT (left invariance). Mode 0 is the identity: a
/// right detection. Immutable once made.
///
/// With a symmetry group G, q_D and q_D g are one detection, so differences are modulo G on the
/// right, and a mode stands for all of q' G; its Difference() is the one nearest to the identity.
/// On the left they are not: the truth q_GT g is the same as q_GT, but it is looked at from another
/// direction in its own frame, g^* v, with the differences g^* q'. Those are that direction's own
/// shares; to merge g^* q' with q' at one direction would mix different orientations.
class ConfusionModel {
 public:
  struct Share {
    int mode = 0;
    double share = 0.0;  ///< > 0
  };

  /// Errors: parameters; a table without trials by direction. Directions never measured take the
  /// shares of their nearest measured neighbor; num_unmeasured() tells how many.
  static Result<ConfusionModel> Make(const ContingencyTable& table,
                                     const SymmetryGroup& symmetry,
                                     const ConfusionModelParameters& parameters = {});

  [[nodiscard]] int num_modes() const { return static_cast<int>(differences_.size()); }
  /// q' of a mode.
  [[nodiscard]] const Eigen::Quaterniond& Difference(int mode) const;
  [[nodiscard]] int num_directions() const { return grid_.num_cells(); }
  [[nodiscard]] int num_unmeasured() const { return num_unmeasured_; }
  /// The cell of the viewing direction of an object in this orientation. O(1).
  [[nodiscard]] int DirectionOf(const Eigen::Quaterniond& q_camera_object) const;
  [[nodiscard]] const DirectionGrid& directions() const { return grid_; }

  /// Modes that occur from a direction, ascending by mode. They and Missed() sum to 1, as measured:
  /// the outlier share is not in them. Likelihoods take it in by WithOutliers().
  [[nodiscard]] std::span<const Share> SharesFrom(int direction) const;
  /// Share of one mode; 0 when it does not occur.
  [[nodiscard]] double ShareFrom(int direction, int mode) const;
  /// Share of trials that tell nothing: nothing was detected, or something of no mode.
  [[nodiscard]] double Missed(int direction) const;
  /// The part of Missed() in which something was detected, but nothing that comes up often enough
  /// to be a mode.
  [[nodiscard]] double Scattered(int direction) const;
  /// Probability of one of the num_modes() + 2 outcomes (a mode, scattered, nothing) of this share:
  /// the outlier share is spread evenly over them.
  [[nodiscard]] double WithOutliers(double share) const {
    const double outliers = parameters_.outlier_share;
    return (1.0 - outliers) * share + outliers / (num_modes() + 2);
  }
  /// Entropy of the outcomes from a direction, each WithOutliers(), nat.
  [[nodiscard]] double Entropy(int direction) const;
  /// Nearest mode of a difference rotation; -1 when none is within mode_radius.
  [[nodiscard]] int ModeOf(const Eigen::Quaterniond& difference) const;

  [[nodiscard]] const SymmetryGroup& symmetry() const { return symmetry_; }
  [[nodiscard]] const ConfusionModelParameters& parameters() const { return parameters_; }

 private:
  ConfusionModel(int num_directions,
                 const SymmetryGroup& symmetry,
                 const ConfusionModelParameters& parameters)
      : grid_(num_directions), symmetry_(symmetry), parameters_(parameters) {}
  void TakeShares(const std::vector<std::vector<Share>>& shares);
  [[nodiscard]] size_t Checked(int direction) const;

  DirectionGrid grid_;
  SymmetryGroup symmetry_;
  ConfusionModelParameters parameters_;
  std::vector<Eigen::Quaterniond> differences_;
  std::vector<Share> shares_;        // Of all directions, one after the other.
  std::vector<size_t> first_share_;  // By direction; one more at the end.
  std::vector<double> nothing_;      // By direction: the part of missed_ without a detection.
  std::vector<double> missed_, entropy_;
  int num_unmeasured_ = 0;
};

}  // namespace vantage
