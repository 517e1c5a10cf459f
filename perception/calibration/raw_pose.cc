#include "perception/calibration/raw_pose.h"

#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <span>

#include "common/format.h"

namespace vantage {
namespace {

constexpr double kFarthest = 1e6;  // m
constexpr double kMatrixTolerance = 0.01;

Error Wrong(std::string message) { return {ErrorCode::kInvalidArgument, std::move(message)}; }

Result<Eigen::Matrix3d> RotationFromMatrix(const std::array<double, 9>& numbers) {
  const Eigen::Matrix3d matrix =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(numbers.data());
  const double determinant = matrix.determinant();
  if (std::abs(determinant + 1.0) < 0.1) {
    return Wrong(
        Format("rotation matrix has determinant %.3g: it mirrors (left-handed axes), expected 1",
               determinant));
  }
  return ProjectToRotation(matrix, kMatrixTolerance);
}

Result<Eigen::Matrix3d> RotationFromVector(const Eigen::Vector3d& vector) {
  const double angle = vector.norm();
  if (!std::isfinite(angle)) return Wrong("rotation vector has numbers that are not finite");
  if (!(angle <= 2.0 * std::numbers::pi * (1.0 + 1e-6))) {
    return Wrong(
        Format("rotation vector (%g, %g, %g) has length %g, expected at most a turn, 6.28 rad: "
               "degrees for radians?",
               vector.x(),
               vector.y(),
               vector.z(),
               angle));
  }
  return Eigen::Matrix3d(ExpSo3(vector).toRotationMatrix());
}

Result<Eigen::Matrix3d> RotationFromRaw(const RawPose& raw) {
  const std::array<double, 9>& r = raw.rotation;
  switch (raw.kind) {
    case RawPose::Rotation::kRotationVector:
      return RotationFromVector({r[0], r[1], r[2]});
    case RawPose::Rotation::kMatrix:
      return RotationFromMatrix(r);
    case RawPose::Rotation::kQuaternion:
      break;
  }
  const Result<Eigen::Quaterniond> q = QuaternionFromWire(std::span<const double, 4>(r.data(), 4));
  if (!q) return q.error();
  return Eigen::Matrix3d(q->toRotationMatrix());
}

}  // namespace

Result<Pose> PoseFromRaw(const RawPose& raw) {
  const Eigen::Vector3d& t = raw.translation;
  if (!t.allFinite() || t.cwiseAbs().maxCoeff() > kFarthest) {
    return Wrong(Format(
        "translation (%g, %g, %g), expected numbers within %g m", t.x(), t.y(), t.z(), kFarthest));
  }
  const Result<Eigen::Matrix3d> rotation = RotationFromRaw(raw);
  if (!rotation) return rotation.error();
  Pose pose = Pose::Identity();
  pose.linear() = *rotation;
  pose.translation() = t;
  return pose;
}

RawPose RawFromPose(const Pose& pose) {
  RawPose raw{.translation = pose.translation(), .kind = RawPose::Rotation::kMatrix};
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(raw.rotation.data()) = pose.linear();
  return raw;
}

}  // namespace vantage
