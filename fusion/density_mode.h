#pragma once

#include <Eigen/Geometry>
#include <span>

namespace vantage {

/// A detection as a kernel of the density of orientations.
struct OrientationKernel {
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
  double sigma = 0.0;   ///< rad, > 0, standard deviation in each of three axes
  double weight = 1.0;  ///< >= 0
};

/// A local maximum of the density.
struct DensityMode {
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();  ///< canonical
  double density = 0.0;  ///< sum of weight * exp(-d^2 / (2 sigma^2)) / sigma^3, rad^-3
  /// rad^2, of the detections about q, each counting as much as its kernel is high there; of the
  /// rotation vectors r in the world's axes, exp(r) q.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

/// The mode of the kernel density of raw detections that mean shift on SO(3) reaches from `start`.
/// Additive fusion (paper eq. 3) is this density looked at on a grid, and the cluster's mean (eq.
/// 7) an estimate of its mode: here it is found free of the grid. The kernels are not cut off. A
/// fixed point of q <- exp(sum g_i log(q_i q^-1) / sum g_i) q with g_i the kernels' slopes is where
/// the gradient is 0 (Subbarao and Meer 2009, mean shift on Riemannian manifolds).
/// @param kernels at least one with weight > 0 within some sigmas of `start`; otherwise `start`
/// itself comes back with density 0.
DensityMode FindDensityMode(std::span<const OrientationKernel> kernels,
                            const Eigen::Quaterniond& start);

}  // namespace vantage
