#include "common/so3.h"

#include <Eigen/SVD>
#include <cmath>

#include "common/format.h"

namespace vantage {

Result<Eigen::Quaterniond> QuaternionFromWire(std::span<const double, 4> wxyz, double tolerance) {
  const Eigen::Quaterniond q(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
  const double norm = q.norm();
  if (!std::isfinite(norm) || std::abs(norm - 1.0) > tolerance) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("quaternion (w, x, y, z) = (%g, %g, %g, %g) has norm %g, expected 1 within "
                        "%g",
                        wxyz[0],
                        wxyz[1],
                        wxyz[2],
                        wxyz[3],
                        norm,
                        tolerance)};
  }
  return Eigen::Quaterniond(q.coeffs() / norm);
}

Result<Pose> PoseFromWire(std::span<const double, 3> trans, std::span<const double, 4> wxyz) {
  constexpr double kFarthest = 1e6;
  for (const double value : trans) {
    if (!std::isfinite(value) || std::abs(value) > kFarthest) {
      return Error{ErrorCode::kInvalidArgument,
                   Format("translation (%g, %g, %g) is not finite or beyond %g m",
                          trans[0],
                          trans[1],
                          trans[2],
                          kFarthest)};
    }
  }
  const Result<Eigen::Quaterniond> q = QuaternionFromWire(wxyz);
  if (!q) return q.error();
  Pose pose = Pose::Identity();
  pose.linear() = q->toRotationMatrix();
  pose.translation() = Eigen::Vector3d(trans[0], trans[1], trans[2]);
  return pose;
}

Result<Eigen::Matrix3d> ProjectToRotation(const Eigen::Matrix3d& matrix, double tolerance) {
  if (!matrix.allFinite()) {
    return Error{ErrorCode::kInvalidArgument, "rotation matrix has entries that are not finite"};
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d rotation = svd.matrixU() * svd.matrixV().transpose();
  const double deviation = (svd.singularValues().array() - 1.0).abs().maxCoeff();
  if (deviation > tolerance || rotation.determinant() < 0.0) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("matrix with determinant %g is %g from a rotation, expected at most %g",
                        matrix.determinant(),
                        deviation,
                        tolerance)};
  }
  return rotation;
}

double GeodesicAngle(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  // atan2 of the difference rotation: acos of the dot product loses half the digits near 0.
  const Eigen::Quaterniond difference = a.conjugate() * b;
  return 2.0 * std::atan2(difference.vec().norm(), std::abs(difference.w()));
}

Eigen::Quaterniond ExpSo3(const Eigen::Vector3d& rotation_vector) {
  const double angle = rotation_vector.norm();
  // sin(angle / 2) / angle, by its series where the quotient would lose digits.
  const double scale = angle < 1e-4 ? 0.5 - angle * angle / 48.0 : std::sin(0.5 * angle) / angle;
  Eigen::Quaterniond q;
  q.w() = std::cos(0.5 * angle);
  q.vec() = scale * rotation_vector;
  return q.normalized();
}

Eigen::Vector3d LogSo3(const Eigen::Quaterniond& q) {
  const Eigen::Quaterniond canonical = Canonical(q);
  const double sine = canonical.vec().norm();
  if (sine < 1e-12) return 2.0 * canonical.vec();
  return canonical.vec() * (2.0 * std::atan2(sine, canonical.w()) / sine);
}

Eigen::Quaterniond Canonical(const Eigen::Quaterniond& q) {
  for (const double value : {q.w(), q.z(), q.y(), q.x()}) {
    if (value > 0.0) return q;
    if (value < 0.0) return Eigen::Quaterniond(-q.coeffs());
  }
  return q;
}

Pose LookAt(const Eigen::Vector3d& eye, const Eigen::Vector3d& target, const Eigen::Vector3d& up) {
  const Eigen::Vector3d z = (target - eye).normalized();
  Eigen::Vector3d x = z.cross(up);
  if (x.norm() < 1e-6 * up.norm()) x = z.unitOrthogonal();
  x.normalize();
  Pose T_world_camera = Pose::Identity();
  T_world_camera.linear().col(0) = x;
  T_world_camera.linear().col(1) = z.cross(x);
  T_world_camera.linear().col(2) = z;
  T_world_camera.translation() = eye;
  return T_world_camera;
}

}  // namespace vantage
