#include "perception/calibration/variance_components.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

namespace vantage {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// The least noise by what was told: below, rounding counts.
constexpr double kLeastNoise = 0.02;
/// As many degrees of freedom the told ratio of the robot's rotation and translation counts.
constexpr double kRatioFreedom = 1.0;

/// Information and gradient of one view, whitened.
struct Whitened {
  MatrixXd information;
  VectorXd gradient;
};

Whitened Whiten(const ViewEquations& view, const ReprojectionNoise& noise) {
  Whitened sum{MatrixXd::Zero(view.pixels.information.rows(), view.pixels.information.cols()),
               VectorXd::Zero(view.pixels.gradient.size())};
  const auto add = [&sum](const ViewEquations::Part& part, double sigma) {
    sum.information += part.information / (sigma * sigma);
    sum.gradient += part.gradient / (sigma * sigma);
  };
  add(view.pixels, noise.pixel);
  add(view.robot_rotation, noise.robot_rotation);
  add(view.robot_translation, noise.robot_translation);
  return sum;
}

/// Inverse of a symmetric matrix of mixed units; directions without information get a very large
/// variance.
MatrixXd BoundedInverse(const MatrixXd& information) {
  const VectorXd unit = information.diagonal().cwiseMax(1e-12).cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(unit.asDiagonal() * information *
                                                      unit.asDiagonal());
  const MatrixXd vectors = unit.asDiagonal() * eigen.eigenvectors();
  return vectors * eigen.eigenvalues().cwiseMax(1e-12).cwiseInverse().asDiagonal() *
         vectors.transpose();
}

/// The covariance of a view's pose and what is shared, from that of what is shared.
MatrixXd JointCovariance(const Whitened& view, const MatrixXd& shared) {
  const Eigen::Index size = view.information.rows();
  const Matrix6d own = Matrix6d(view.information.topLeftCorner<6, 6>()).inverse();
  const MatrixXd gain = -own * view.information.topRightCorner(6, size - 6);
  MatrixXd joint(size, size);
  joint.topLeftCorner<6, 6>() = own + gain * shared * gain.transpose();
  joint.topRightCorner(6, size - 6) = gain * shared;
  joint.bottomLeftCorner(size - 6, 6) = joint.topRightCorner(6, size - 6).transpose();
  joint.bottomRightCorner(size - 6, size - 6) = shared;
  return joint;
}

double Square(double value) { return value * value; }

}  // namespace

SharedEquations ShareEquations(std::span<const ViewEquations> views,
                               const ReprojectionNoise& noise,
                               const VectorXd& prior) {
  SharedEquations shared;
  shared.information = prior.asDiagonal();
  for (const ViewEquations& view : views) {
    const Whitened whitened = Whiten(view, noise);
    const Eigen::Index size = prior.size();
    const Eigen::LDLT<Matrix6d> own(Matrix6d(whitened.information.topLeftCorner<6, 6>()));
    const MatrixXd cross = whitened.information.topRightCorner(6, size);
    shared.of_view.push_back(whitened.information.bottomRightCorner(size, size) -
                             cross.transpose() * own.solve(cross));
    shared.gradient_of_view.push_back(whitened.gradient.tail(size) -
                                      cross.transpose() * own.solve(whitened.gradient.head<6>()));
    shared.information += shared.of_view.back();
  }
  shared.covariance = BoundedInverse(shared.information);
  return shared;
}

NoiseEstimate EstimateNoise(std::span<const ViewEquations> views,
                            const ReprojectionNoise& told,
                            const ReprojectionNoise& current,
                            const VectorXd& prior) {
  const MatrixXd shared = ShareEquations(views, current, prior).covariance;
  NoiseEstimate estimate;
  double pixels = 0.0;
  double rotations = 0.0;
  double translations = 0.0;
  for (const ViewEquations& view : views) {
    const MatrixXd joint = JointCovariance(Whiten(view, current), shared);
    const auto taken = [&joint](const ViewEquations::Part& part, double sigma) {
      return joint.cwiseProduct(part.information).sum() / Square(sigma);
    };
    pixels += view.pixels.squared_error;
    rotations += view.robot_rotation.squared_error;
    translations += view.robot_translation.squared_error;
    estimate.pixel_freedom += view.num_pixels - taken(view.pixels, current.pixel);
    estimate.rotation_freedom += 3.0 - taken(view.robot_rotation, current.robot_rotation);
    estimate.translation_freedom += 3.0 - taken(view.robot_translation, current.robot_translation);
  }
  estimate.noise = current;
  const double freedom = estimate.rotation_freedom + estimate.translation_freedom;
  if (freedom > 0.5) {
    const double common =
        (rotations / Square(told.robot_rotation) + translations / Square(told.robot_translation)) /
        freedom;
    const auto sigma = [common](double squares, double degrees, double told_sigma) {
      const double expected = kRatioFreedom * common * Square(told_sigma);
      const double variance = (squares + expected) / (std::max(degrees, 0.0) + kRatioFreedom);
      return std::max(std::sqrt(variance), kLeastNoise * told_sigma);
    };
    estimate.noise.robot_rotation =
        sigma(rotations, estimate.rotation_freedom, told.robot_rotation);
    estimate.noise.robot_translation =
        sigma(translations, estimate.translation_freedom, told.robot_translation);
  }
  if (estimate.pixel_freedom > 0.5) {
    estimate.noise.pixel =
        std::max(std::sqrt(pixels / estimate.pixel_freedom), kLeastNoise * told.pixel);
  }
  return estimate;
}

double EffectiveFreedom(std::span<const ViewEquations> views,
                        const NoiseEstimate& estimate,
                        const VectorXd& prior) {
  const auto covariance_of_x = [&](const ReprojectionNoise& noise) {
    return Matrix6d(ShareEquations(views, noise, prior).covariance.topLeftCorner<6, 6>());
  };
  const Matrix6d now = covariance_of_x(estimate.noise);
  // By how much the covariance grows with each component, by differences.
  constexpr double kStep = 0.01;
  const auto share = [&](double ReprojectionNoise::*sigma) {
    ReprojectionNoise larger = estimate.noise;
    larger.*sigma *= std::sqrt(1.0 + kStep);
    return now.ldlt().solve(covariance_of_x(larger) - now).trace() / (6.0 * kStep);
  };
  const std::array<std::pair<double, double>, 3> shares = {
      std::pair{share(&ReprojectionNoise::pixel), estimate.pixel_freedom},
      std::pair{share(&ReprojectionNoise::robot_rotation), estimate.rotation_freedom},
      std::pair{share(&ReprojectionNoise::robot_translation), estimate.translation_freedom}};
  double sum = 0.0;
  for (const auto& [part, freedom] : shares) sum += part * part / std::max(freedom, 1.0);
  return std::max(1.0, 1.0 / std::max(sum, 1e-9));
}

}  // namespace vantage
