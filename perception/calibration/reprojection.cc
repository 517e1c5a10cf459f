#include "perception/calibration/reprojection.h"

namespace vantage {

Reprojection Reproject(const CameraModel& camera,
                       const LensDistortion& distortion,
                       const Eigen::Vector3d& p_camera) {
  const double inverse_z = 1.0 / p_camera.z();
  const double x = p_camera.x() * inverse_z;
  const double y = p_camera.y() * inverse_z;
  const double r2 = x * x + y * y;
  const auto& [k1, k2, p1, p2, k3] = distortion;
  const double radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double radial_by_r2 = k1 + r2 * (2.0 * k2 + 3.0 * r2 * k3);
  const Eigen::Vector2d shown = distortion.Distort(Eigen::Vector2d(x, y));

  Eigen::Matrix2d shown_by_ray;
  shown_by_ray(0, 0) = radial + 2.0 * x * x * radial_by_r2 + 2.0 * p1 * y + 6.0 * p2 * x;
  shown_by_ray(0, 1) = 2.0 * x * y * radial_by_r2 + 2.0 * p1 * x + 2.0 * p2 * y;
  shown_by_ray(1, 0) = shown_by_ray(0, 1);
  shown_by_ray(1, 1) = radial + 2.0 * y * y * radial_by_r2 + 6.0 * p1 * y + 2.0 * p2 * x;
  Eigen::Matrix<double, 2, 3> ray_by_point;
  ray_by_point << inverse_z, 0.0, -x * inverse_z, 0.0, inverse_z, -y * inverse_z;

  const Eigen::Vector2d focal(camera.fx, camera.fy);
  Reprojection result;
  result.pixel = focal.cwiseProduct(shown) + Eigen::Vector2d(camera.cx, camera.cy);
  result.by_point = focal.asDiagonal() * shown_by_ray * ray_by_point;
  result.by_pinhole << shown.x(), 0.0, 1.0, 0.0, 0.0, shown.y(), 0.0, 1.0;
  result.by_distortion << x * r2, x * r2 * r2, 2.0 * x * y, r2 + 2.0 * x * x, y * r2, y * r2 * r2,
      r2 + 2.0 * y * y, 2.0 * x * y;
  result.by_distortion = focal.asDiagonal() * result.by_distortion;
  return result;
}

}  // namespace vantage
