#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "common/result.h"

namespace vantage {

/// The orientation of an object as one view saw it.
struct OrientationView {
  Eigen::Quaterniond q_world_object = Eigen::Quaterniond::Identity();
  double mse = 0.0;  ///< m^2, of the detection (paper eq. 4)
  /// Where it was seen from; needed where a confusion model is used, none: not known.
  std::optional<Eigen::Quaterniond> q_world_camera = std::nullopt;

  /// Quaternions of norm 1 within 1e-3, an mse that is finite and >= 0.
  [[nodiscard]] Result<void> Validate() const;

  bool operator==(const OrientationView& other) const {
    const auto& camera = q_world_camera;
    return q_world_object.coeffs() == other.q_world_object.coeffs() && mse == other.mse &&
           camera.has_value() == other.q_world_camera.has_value() &&
           (!camera || camera->coeffs() == other.q_world_camera->coeffs());
  }
};

}  // namespace vantage
