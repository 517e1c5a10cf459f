#pragma once

#include <Eigen/Core>
#include <optional>

namespace vantage {

/// What a lens does to a line of sight: Brown, "Close-Range Camera Calibration", 1971, with the
/// signs of OpenCV, the coefficients in its order and that of camera_info_t.
struct LensDistortion {
  double k1 = 0.0;  ///< radial, of r^2
  double k2 = 0.0;  ///< radial, of r^4
  double p1 = 0.0;  ///< tangential
  double p2 = 0.0;  ///< tangential
  double k3 = 0.0;  ///< radial, of r^6

  [[nodiscard]] bool IsNone() const {
    return k1 == 0.0 && k2 == 0.0 && p1 == 0.0 && p2 == 0.0 && k3 == 0.0;
  }
  /// (x / z, y / z) of a point as a pinhole sees it, to where this lens shows it.
  [[nodiscard]] Eigen::Vector2d Distort(const Eigen::Vector2d& point) const {
    const double x = point.x();
    const double y = point.y();
    const double r2 = x * x + y * y;
    const double radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
    return {x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
            y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y};
  }
  /// Inverse of Distort(), by Newton's method. Nothing where no point is shown, or where it does
  /// not converge.
  [[nodiscard]] std::optional<Eigen::Vector2d> Undistort(const Eigen::Vector2d& point) const;

  bool operator==(const LensDistortion&) const = default;
};

}  // namespace vantage
