#include "fusion/density_mode.h"

#include <cmath>

#include "common/so3.h"

namespace vantage {
namespace {

constexpr int kMostSteps = 200;
constexpr double kSmallestStep = 1e-10;  // rad

// Height of a kernel at squared distance d^2, without the constant (2 pi)^(-3/2).
double Height(const OrientationKernel& kernel, double squared_angle) {
  const double variance = kernel.sigma * kernel.sigma;
  return kernel.weight * std::exp(-0.5 * squared_angle / variance) / (variance * kernel.sigma);
}

}  // namespace

DensityMode FindDensityMode(std::span<const OrientationKernel> kernels,
                            const Eigen::Quaterniond& start) {
  Eigen::Quaterniond q = start.normalized();
  for (int step = 0; step < kMostSteps; ++step) {
    double slope_sum = 0.0;
    Eigen::Vector3d shift = Eigen::Vector3d::Zero();
    const Eigen::Quaterniond q_inverse = q.conjugate();
    for (const OrientationKernel& kernel : kernels) {
      const Eigen::Vector3d r = LogSo3(kernel.q * q_inverse);
      const double slope = Height(kernel, r.squaredNorm()) / (kernel.sigma * kernel.sigma);
      slope_sum += slope;
      shift += slope * r;
    }
    if (!(slope_sum > 0.0)) break;
    shift /= slope_sum;
    q = (ExpSo3(shift) * q).normalized();
    if (shift.norm() < kSmallestStep) break;
  }

  DensityMode mode;
  mode.q = Canonical(q);
  const Eigen::Quaterniond q_inverse = mode.q.conjugate();
  for (const OrientationKernel& kernel : kernels) {
    const Eigen::Vector3d r = LogSo3(kernel.q * q_inverse);
    const double height = Height(kernel, r.squaredNorm());
    mode.density += height;
    mode.covariance += height * r * r.transpose();
  }
  if (mode.density > 0.0) mode.covariance /= mode.density;
  return mode;
}

}  // namespace vantage
