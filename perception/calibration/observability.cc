#include "perception/calibration/observability.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "common/format.h"
#include "perception/calibration/closed_form.h"

namespace vantage {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kRotationUnit = 0.1 * kDegree;  // rad
constexpr double kTranslationUnit = 0.001;       // m
/// Orientations that spread less about an axis say nothing that one would build on, rad.
constexpr double kLeastSpread = 1.0 * kDegree;
constexpr double kSpreadByNoise = 10.0;
/// Positions that spread less are the same place, m.
constexpr double kLeastTravel = 0.001;
/// Below, X is known to 25 mm or 2.5 deg at best.
constexpr double kLeastSingularValue = 0.04;
constexpr size_t kFewestViews = 3;

/// Where the hand was, in the axes that X's error has.
struct Motion {
  Vector3d spread = Vector3d::Zero();    ///< rad, about the columns of `axes`
  Matrix3d axes = Matrix3d::Identity();  ///< of X's error
  double travel = 0.0;                   ///< m, of positions, root of their mean square
};

Motion MeasureMotion(HandEyeSetup setup, std::span<const Pose> T_base_hand) {
  Motion motion;
  if (T_base_hand.empty()) return motion;
  const double count = static_cast<double>(T_base_hand.size());
  // The mean is the leading eigenvector (Markley et al., "Averaging Quaternions", 2007).
  Eigen::Matrix4d sum = Eigen::Matrix4d::Zero();
  Vector3d mean_position = Vector3d::Zero();
  std::vector<Quaterniond> orientations;
  for (const Pose& pose : T_base_hand) {
    orientations.emplace_back(EquationOfHand(setup, pose).linear());
    sum += orientations.back().coeffs() * orientations.back().coeffs().transpose();
    mean_position += pose.translation() / count;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> mean(sum);
  const Quaterniond q_mean(Eigen::Vector4d(mean.eigenvectors().col(3)));
  Matrix3d covariance = Matrix3d::Zero();
  for (const Quaterniond& q : orientations) {
    const Vector3d deviation = LogSo3(q_mean.conjugate() * q);
    covariance += deviation * deviation.transpose() / count;
  }
  const Eigen::SelfAdjointEigenSolver<Matrix3d> principal(covariance);
  for (int i = 0; i < 3; ++i) {
    motion.spread[i] = std::sqrt(std::max(0.0, principal.eigenvalues()[2 - i]));
    motion.axes.col(i) = principal.eigenvectors().col(2 - i);
  }
  for (const Pose& pose : T_base_hand) {
    motion.travel += (pose.translation() - mean_position).squaredNorm() / count;
  }
  motion.travel = std::sqrt(motion.travel);
  return motion;
}

/// Some rotation of X has a standard deviation of more than 1 deg.
bool IsRotationOpen(const HandEyeCovariance& scaled) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> rotation(Matrix3d(scaled.topLeftCorner<3, 3>()));
  return rotation.eigenvalues()[2] > 100.0;
}

std::string AxisText(const Vector3d& axis) {
  // The same axis in one way: its largest component is positive.
  Eigen::Index largest = 0;
  axis.cwiseAbs().maxCoeff(&largest);
  Vector3d shown = axis[largest] < 0.0 ? Vector3d(-axis) : axis;
  for (double& value : shown) {
    if (std::abs(value) < 0.005) value = 0.0;  // No "-0.00".
  }
  return Format("(%.2f, %.2f, %.2f)", shown.x(), shown.y(), shown.z());
}

struct Words {
  const char* transform;
  const char* axes;
};

Words WordsOf(HandEyeSetup setup) {
  return setup == HandEyeSetup::kEyeInHand ? Words{"T_hand_camera", "the hand's axes"}
                                           : Words{"T_base_camera", "the base's axes"};
}

std::string OneAxisReason(const Words& words, const Motion& motion, bool is_rotation_open) {
  const std::string axis = AxisText(motion.axes.col(0));
  return Format(
      "the hand turns about one axis only, %s in %s, about others by %.2f deg: the translation of "
      "%s along it%s not fixed; add views rotated about another axis",
      axis.c_str(),
      words.axes,
      motion.spread[1] / kDegree,
      words.transform,
      is_rotation_open ? " and its rotation are" : " is");
}

std::string WeakReason(const Words& words,
                       const Eigen::SelfAdjointEigenSolver<HandEyeCovariance>& scaled) {
  const double sigma = std::sqrt(scaled.eigenvalues()[5]);
  const Eigen::Matrix<double, 6, 1> direction = scaled.eigenvectors().col(5);
  const bool is_translation = direction.tail<3>().norm() > direction.head<3>().norm();
  const Vector3d axis = is_translation ? direction.tail<3>() : direction.head<3>();
  return Format("%s is known only to %.3g %s %s %s of %s; add views with larger rotations",
                words.transform,
                is_translation ? sigma : 0.1 * sigma,
                is_translation ? "mm" : "deg",
                is_translation ? "along" : "about",
                AxisText(axis.normalized()).c_str(),
                words.axes);
}

}  // namespace

Observability AssessObservability(HandEyeSetup setup,
                                  std::span<const Pose> T_base_hand,
                                  const HandEyeCovariance& covariance,
                                  double robot_rotation) {
  Observability result;
  const Motion motion = MeasureMotion(setup, T_base_hand);
  result.rotation_spread = motion.spread;
  Eigen::Matrix<double, 6, 1> unit;
  unit << Vector3d::Constant(kRotationUnit), Vector3d::Constant(kTranslationUnit);
  const HandEyeCovariance scaled =
      unit.cwiseInverse().asDiagonal() * covariance * unit.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<HandEyeCovariance> eigen(scaled);
  for (int i = 0; i < 6; ++i) {
    result.singular_values[i] = 1.0 / std::sqrt(std::max(1e-18, eigen.eigenvalues()[i]));
  }

  const Words words = WordsOf(setup);
  const double least_spread = std::max(kLeastSpread, kSpreadByNoise * robot_rotation);
  if (T_base_hand.size() < kFewestViews) {
    result.reason =
        Format("only %zu views agree with each other, at least %zu are needed; add views",
               T_base_hand.size(),
               kFewestViews);
  } else if (motion.spread[0] < least_spread && motion.travel < kLeastTravel) {
    result.reason = Format(
        "all views are from the same pose of the hand within %.3g mm and %.3g deg; add views from "
        "other places, rotated about at least two axes",
        motion.travel * 1e3,
        motion.spread[0] / kDegree);
  } else if (motion.spread[0] < least_spread) {
    result.reason = Format(
        "the hand moves but turns by %.3g deg only: the translation of %s is not fixed; add views "
        "rotated about at least two axes",
        motion.spread[0] / kDegree,
        words.transform);
  } else if (motion.spread[1] < least_spread) {
    result.reason = OneAxisReason(words, motion, IsRotationOpen(scaled));
  } else if (!(result.singular_values[5] >= kLeastSingularValue)) {
    result.reason = WeakReason(words, eigen);
  }
  result.is_sufficient = result.reason.empty();
  return result;
}

}  // namespace vantage
