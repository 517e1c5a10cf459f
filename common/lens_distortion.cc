#include "common/lens_distortion.h"

#include <cmath>

namespace vantage {

std::optional<Eigen::Vector2d> LensDistortion::Undistort(const Eigen::Vector2d& point) const {
  constexpr int kMostSteps = 30;
  const double tolerance = 1e-10 * (1.0 + point.norm());
  Eigen::Vector2d ideal = point;
  for (int step = 0; step < kMostSteps; ++step) {
    const double x = ideal.x();
    const double y = ideal.y();
    const double r2 = x * x + y * y;
    const double radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
    const double slope = k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3);  // Of `radial` by r2.
    const double xx = radial + 2.0 * x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x;
    const double yy = radial + 2.0 * y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x;
    const double xy = 2.0 * x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y;
    const double determinant = xx * yy - xy * xy;
    const Eigen::Vector2d error = Distort(ideal) - point;
    // Where it is not positive, the lens has folded the image over. NaN fails.
    if (!(radial > 0.0 && determinant > 0.0)) return std::nullopt;
    if (error.norm() <= tolerance) return ideal;
    ideal.x() -= (yy * error.x() - xy * error.y()) / determinant;
    ideal.y() -= (xx * error.y() - xy * error.x()) / determinant;
  }
  return std::nullopt;
}

}  // namespace vantage
