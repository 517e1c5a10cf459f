#include "perception/calibration/target_pose.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <optional>

#include "common/format.h"
#include "perception/calibration/reprojection.h"

namespace vantage {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

/// How much worse, in squared standard deviations of a pixel, a solution may explain the image and
/// still be the true one: two images a distance d apart differ in their sums of squares by no more
/// than 2 d z - d^2 <= z^2 to the disadvantage of the true one, where the noise is z standard
/// deviations along the line from one to the other. Here z = 5.
constexpr double kLargestDifference = 25.0;

Error Invalid(std::string message) { return {ErrorCode::kInvalidArgument, std::move(message)}; }

/// The normal equations of a pose's reprojection errors, by rotation vector and translation in the
/// camera's axes.
struct NormalEquations {
  Matrix6d information = Matrix6d::Zero();  ///< px^2
  Vector6d gradient = Vector6d::Zero();
  double squared_error = 0.0;  ///< px^2; infinite where a point is not in front of the camera
};

NormalEquations Linearize(std::span<const TargetPoint> points,
                          const CameraModel& camera,
                          const LensDistortion& distortion,
                          const Pose& T_camera_target) {
  NormalEquations equations;
  for (const TargetPoint& point : points) {
    const Vector3d turned = T_camera_target.linear() * point.p_target;
    const Vector3d p_camera = turned + T_camera_target.translation();
    if (!(p_camera.z() > 1e-6)) {
      equations.squared_error = std::numeric_limits<double>::infinity();
      return equations;
    }
    const Reprojection shown = Reproject(camera, distortion, p_camera);
    const Vector2d error = shown.pixel - point.pixel;
    Eigen::Matrix<double, 2, 6> jacobian;
    // d(exp(r) q) / dr = -[q]x.
    for (int row = 0; row < 2; ++row) {
      jacobian.row(row).head<3>() = turned.cross(shown.by_point.row(row).transpose()).transpose();
    }
    jacobian.rightCols<3>() = shown.by_point;
    equations.information.noalias() += jacobian.transpose() * jacobian;
    equations.gradient.noalias() += jacobian.transpose() * error;
    equations.squared_error += error.squaredNorm();
  }
  return equations;
}

struct Solution {
  Pose T_camera_target = Pose::Identity();
  NormalEquations equations;
};

/// Least squares from a start (Levenberg-Marquardt). Nothing where a point is behind the camera.
std::optional<Solution> Refine(std::span<const TargetPoint> points,
                               const CameraModel& camera,
                               const LensDistortion& distortion,
                               const Pose& start) {
  constexpr int kMostSteps = 50;
  Solution solution{start, Linearize(points, camera, distortion, start)};
  if (!std::isfinite(solution.equations.squared_error)) return std::nullopt;
  double damping = 1e-4;
  for (int i = 0; i < kMostSteps && damping < 1e8; ++i) {
    const NormalEquations& now = solution.equations;
    Matrix6d damped = now.information;
    damped.diagonal() *= 1.0 + damping;
    const Vector6d step = -damped.ldlt().solve(now.gradient);
    if (!step.allFinite()) return std::nullopt;
    Pose next = solution.T_camera_target;
    next.linear() = ExpSo3(step.head<3>()).toRotationMatrix() * next.linear();
    next.translation() += step.tail<3>();
    NormalEquations tried = Linearize(points, camera, distortion, next);
    if (!(tried.squared_error <= now.squared_error)) {
      damping *= 10.0;
      continue;
    }
    const double gain = now.squared_error - tried.squared_error;
    solution = {next, tried};
    damping = std::max(0.1 * damping, 1e-12);
    if (gain <= 1e-12 * tried.squared_error + 1e-18) break;
  }
  return solution;
}

Result<void> Check(std::span<const TargetPoint> points, double pixel_sigma) {
  if (points.size() < 4) {
    return Invalid(
        Format("%zu points of the target in the image, expected at least 4", points.size()));
  }
  if (!(pixel_sigma > 0.0 && pixel_sigma <= 1e3)) {
    return Invalid(
        Format("noise of a point in an image of %g px, expected above 0 to 1000", pixel_sigma));
  }
  Vector2d mean = Vector2d::Zero();
  for (const TargetPoint& point : points) {
    if (!(point.p_target.norm() <= 1e3 && point.pixel.norm() <= 1e6) ||
        std::abs(point.p_target.z()) > 1e-9) {
      return Invalid(
          Format("point (%g, %g, %g) m of the target at pixel (%g, %g), expected finite "
                 "numbers and z = 0",
                 point.p_target.x(),
                 point.p_target.y(),
                 point.p_target.z(),
                 point.pixel.x(),
                 point.pixel.y()));
    }
    mean += point.p_target.head<2>() / static_cast<double>(points.size());
  }
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const TargetPoint& point : points) {
    const Vector2d arm = point.p_target.head<2>() - mean;
    scatter += arm * arm.transpose();
  }
  const Vector2d spread = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(scatter).eigenvalues();
  if (!(spread(0) > 1e-6 * spread(1))) {
    return Invalid("the points of the target lie in a line, expected a plane");
  }
  return {};
}

/// Both solutions of a flat target without regard to noise (Collins, Bartoli 2014).
std::vector<Pose> ClosedForm(std::span<const TargetPoint> points,
                             const CameraModel& camera,
                             const LensDistortion& distortion) {
  std::vector<cv::Point3d> on_target;
  std::vector<cv::Point2d> shown;
  for (const TargetPoint& point : points) {
    on_target.emplace_back(point.p_target.x(), point.p_target.y(), 0.0);
    shown.emplace_back(point.pixel.x(), point.pixel.y());
  }
  const cv::Matx33d pinhole(camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0);
  const cv::Vec<double, 5> lens(
      distortion.k1, distortion.k2, distortion.p1, distortion.p2, distortion.k3);
  std::vector<cv::Mat> rotations;
  std::vector<cv::Mat> translations;
  std::vector<Pose> poses;
  // OpenCV throws where its numbers get out of hand.
  try {
    std::vector<cv::Point2d> rays;
    const cv::TermCriteria enough(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 30, 1e-10);
    cv::undistortPoints(shown, rays, pinhole, lens, cv::noArray(), cv::noArray(), enough);
    cv::solvePnPGeneric(on_target,
                        rays,
                        cv::Matx33d::eye(),
                        cv::noArray(),
                        rotations,
                        translations,
                        false,
                        cv::SOLVEPNP_IPPE);
    for (size_t i = 0; i < rotations.size() && i < translations.size(); ++i) {
      const cv::Vec3d r = rotations[i];
      const cv::Vec3d t = translations[i];
      Pose pose = Pose::Identity();
      pose.linear() = ExpSo3(Vector3d(r[0], r[1], r[2])).toRotationMatrix();
      pose.translation() = Vector3d(t[0], t[1], t[2]);
      if (pose.matrix().allFinite()) poses.push_back(pose);
    }
  } catch (const cv::Exception&) {
    return {};
  }
  return poses;
}

bool IsSame(const Pose& a, const Pose& b) {
  return GeodesicAngle(Eigen::Quaterniond(a.linear()), Eigen::Quaterniond(b.linear())) < 1e-4 &&
         (a.translation() - b.translation()).norm() < 1e-4 * a.translation().norm();
}

}  // namespace

Result<std::vector<TargetPose>> FindTargetPoses(std::span<const TargetPoint> points,
                                                const CameraModel& camera,
                                                const LensDistortion& distortion,
                                                double pixel_sigma) {
  if (const auto valid = camera.Validate(); !valid) return valid.error();
  if (const auto valid = Check(points, pixel_sigma); !valid) return valid.error();
  std::vector<Solution> solutions;
  for (const Pose& start : ClosedForm(points, camera, distortion)) {
    const auto refined = Refine(points, camera, distortion, start);
    if (refined) solutions.push_back(*refined);
  }
  if (solutions.empty()) {
    return Invalid(Format("no pose of the target in front of the camera explains its %zu points",
                          points.size()));
  }
  std::stable_sort(solutions.begin(), solutions.end(), [](const Solution& a, const Solution& b) {
    return a.equations.squared_error < b.equations.squared_error;
  });
  const double least = solutions.front().equations.squared_error;
  const double redundancy = std::max(1.0, 2.0 * static_cast<double>(points.size()) - 6.0);
  const double variance = std::max(pixel_sigma * pixel_sigma, least / redundancy);
  std::vector<TargetPose> poses;
  for (const Solution& solution : solutions) {
    const double squared_error = solution.equations.squared_error;
    if (squared_error - least > kLargestDifference * variance) break;
    if (!poses.empty() && IsSame(poses[0].T_camera_target, solution.T_camera_target)) continue;
    poses.push_back(
        {.T_camera_target = solution.T_camera_target,
         .pixel_rms = std::sqrt(squared_error / (2.0 * static_cast<double>(points.size()))),
         .covariance = pixel_sigma * pixel_sigma * solution.equations.information.inverse()});
  }
  return poses;
}

}  // namespace vantage
