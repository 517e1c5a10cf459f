#pragma once

#include <Eigen/Core>
#include <vector>

#include "perception/calibration/pose_adjustment.h"

namespace vantage {

/// What the residuals of adjusted views say of noise and outliers.
struct ResidualStatistics {
  Eigen::MatrixXd information;  ///< of what is estimated, J^T J over the views used
  Eigen::MatrixXd covariance;   ///< its inverse; very large where nothing is known
  ResidualScales scales;
  double rotation_freedom = 0.0;  ///< degrees, that the scales rest on
  double translation_freedom = 0.0;
  /// Of each view: whether its residual is too large for its noise, as told by the others.
  std::vector<bool> is_outlier;
};

/// @param uses of each view, whether it was adjusted. @param present scales that the residuals are
/// whitened by.
ResidualStatistics EvaluateResiduals(const AdjustmentLinearization& linearization,
                                     const std::vector<bool>& uses,
                                     const ResidualScales& present);

/// By what the estimate changes if a view that was used is left out: one step of Gauss-Newton from
/// the optimum.
Eigen::VectorXd StepWithout(const AdjustmentLinearization& linearization,
                            const ResidualStatistics& statistics,
                            size_t view);

/// Inverse of an information matrix of X, Y and what else is estimated.
Eigen::MatrixXd CovarianceOf(const Eigen::MatrixXd& information);

}  // namespace vantage
