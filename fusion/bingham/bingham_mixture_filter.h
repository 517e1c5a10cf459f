#pragma once

#include <Eigen/Geometry>

#include "common/result.h"
#include "common/so3.h"
#include "fusion/bingham/bingham_mixture.h"
#include "fusion/orientation_fusion.h"

namespace vantage {

/// Parameters of BinghamMixtureFilter.
struct BinghamMixtureParameters {
  double sigma = 4.0 * kDegree;  ///< rad, of a detection about each axis; sigma_cw of the histogram
  double peaked_weight = 0.95;   ///< of the measurement that is no outlier (paper 7.2)
  int max_components = 32;       ///< of the state, besides the uniform one

  Result<void> Validate() const;
};

/// BMM M+R, multiplication and reduction, of Riedel, Marton and Kriegel 2016 (paper 7.2): state and
/// measurement are Bingham mixtures, the prior is uniform, and each view multiplies the state by
/// peaked_weight Bingham(detection, sigma) + (1 - peaked_weight) uniform.
class BinghamMixtureFilter : public OrientationFusion {
 public:
  /// @param parameters valid.
  explicit BinghamMixtureFilter(const BinghamMixtureParameters& parameters);

  Result<void> Add(const OrientationView& view) override;
  /// The mode of the mixture's density: the orientation of maximum posterior density. It does not
  /// depend on how many components share a peak, as the mode of the heaviest component would.
  [[nodiscard]] Result<Eigen::Quaterniond> Estimate() const override;

  [[nodiscard]] const BinghamMixture& state() const { return state_; }

 private:
  BinghamMixtureParameters parameters_;
  BinghamMixture state_;
  bool has_view_ = false;
};

}  // namespace vantage
