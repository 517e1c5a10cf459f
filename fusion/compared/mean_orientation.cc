#include "fusion/compared/mean_orientation.h"

#include "fusion/compared/scatter.h"

namespace vantage {

Result<void> MeanOrientation::Add(const OrientationView& view) {
  if (const Result<void> valid = view.Validate(); !valid) return valid.error();
  const Eigen::Vector4d q = view.q_world_object.coeffs().normalized();
  scatter_ += q * q.transpose();
  return {};
}

Result<Eigen::Quaterniond> MeanOrientation::Estimate() const {
  if (scatter_.isZero(0.0)) {
    return Error{ErrorCode::kNotFound, "the mean orientation of no view yet, expected one or more"};
  }
  return MeanOfScatter(scatter_).mean;
}

}  // namespace vantage
