#pragma once

#include <Eigen/Geometry>
#include <span>

#include "common/result.h"
#include "common/so3.h"
#include "common/symmetry_group.h"
#include "fusion/density_mode.h"

namespace vantage {

/// How the exact mode of the density of detections is found.
struct ModeRefinementParameters {
  /// rad, of the kernels that find the mode, and the largest of those that refine it.
  double sigma = 4.0 * kDegree;
  /// The refining kernels are this many times as wide as the detections about the mode scatter
  /// (a robust standard deviation in each axis); 0: as wide as `sigma`. Wider ones average more
  /// detections, narrower ones trust the nearer ones more. docs/evaluation.md has what other
  /// values give.
  double bandwidth = 3.0;
  double smallest_sigma = 0.05 * kDegree;  ///< rad, of the refining kernels
  /// m^2. A detection counts as 1 / (mse + mse_floor), the precision of measurements whose variance
  /// is in proportion to how badly they fit; scale-free, unlike the verification weight.
  double mse_floor = 1e-7;

  Result<void> Validate() const;
};

/// 1 / (mse + mse_floor) in units of mm^-2.
double PrecisionWeight(double mse, const ModeRefinementParameters& parameters);

/// The mode of the density of weighted detections that mean shift reaches from `start`, free of the
/// grid, first with kernels of `sigma`, then as narrow as the detections allow. Detections that a
/// symmetry of the object makes equal count as one place: each is replaced by its equivalent
/// nearest to the mode.
/// @param detections weight >= 0; sigma >= 0 is what each is uncertain by beyond the kernels'
/// width.
DensityMode RefineMode(std::span<const OrientationKernel> detections,
                       const Eigen::Quaterniond& start,
                       const ModeRefinementParameters& parameters,
                       const SymmetryGroup& symmetry);

}  // namespace vantage
