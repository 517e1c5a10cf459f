#include "fusion/bingham/bingham_mixture_filter.h"

#include <cmath>
#include <numbers>

#include "common/check.h"
#include "common/format.h"

namespace vantage {

Result<void> BinghamMixtureParameters::Validate() const {
  if (!(sigma >= 1e-4 && sigma <= std::numbers::pi)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("sigma = %g rad, expected at least 1e-4 and at most pi", sigma)};
  }
  if (!(peaked_weight > 0.0 && peaked_weight < 1.0)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("peaked_weight = %g, expected between 0 and 1", peaked_weight)};
  }
  if (max_components < 1 || max_components > 1000) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("max_components = %d, expected 1 to 1000", max_components)};
  }
  return {};
}

BinghamMixtureFilter::BinghamMixtureFilter(const BinghamMixtureParameters& parameters)
    : parameters_(parameters), state_({BinghamComponent{}}) {
  const Result<void> valid = parameters.Validate();
  VANTAGE_CHECK(valid.ok(), valid.error().message);
}

Result<void> BinghamMixtureFilter::Add(const OrientationView& view) {
  if (const Result<void> valid = view.Validate(); !valid) return valid.error();
  const BinghamMixture measurement(
      {{std::log(parameters_.peaked_weight),
        BinghamDistribution::Isotropic(view.q_world_object, parameters_.sigma)},
       {std::log(1.0 - parameters_.peaked_weight), BinghamDistribution()}});
  state_ = Multiply(state_, measurement);
  state_.Reduce(parameters_.max_components);
  has_view_ = true;
  return {};
}

Result<Eigen::Quaterniond> BinghamMixtureFilter::Estimate() const {
  if (!has_view_) {
    return Error{ErrorCode::kNotFound, "no view was added yet, expected at least one"};
  }
  return state_.Mode();
}

}  // namespace vantage
