#pragma once

#include <Eigen/Geometry>

#include "common/result.h"

namespace vantage {

/// The orientation of an object as one view saw it.
struct OrientationView {
  Eigen::Quaterniond q_world_object = Eigen::Quaterniond::Identity();
  double mse = 0.0;  ///< m^2, of the detection (paper eq. 4)

  /// A quaternion of norm 1 within 1e-3, an mse that is finite and >= 0.
  [[nodiscard]] Result<void> Validate() const;

  bool operator==(const OrientationView& other) const {
    return q_world_object.coeffs() == other.q_world_object.coeffs() && mse == other.mse;
  }
};

}  // namespace vantage
