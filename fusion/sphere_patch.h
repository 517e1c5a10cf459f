#pragma once

#include <Eigen/Core>
#include <array>

namespace vantage {

/// The part of the unit sphere S^3 that lies in one cell of the quaternion lattice.
struct SpherePatch {
  double area = 0.0;  ///< Share of the half sphere, that is, of SO(3).
  /// The normalized centroid of the patch; where the cell touches the sphere in a point, that
  /// point. Unit norm.
  Eigen::Vector4d centroid = Eigen::Vector4d::Zero();
};

/// Integrates the patch inside the box [lower, lower + 1] / k of R^4.
///
/// In the coordinates (x, y) = sqrt(s) e^(i a), (z, w) = sqrt(1 - s) e^(i b) the surface element of
/// S^3 is ds da db / 2. A box bounds a and b to arcs whose lengths are closed forms in s, so one
/// quadrature over s remains, piecewise smooth between the squared radii of the box's corners.
/// Relative error below 1e-12.
/// @param lower 0 <= lower[i] < k, so that the box lies in the positive orthant.
SpherePatch IntegrateSpherePatch(const std::array<int, 4>& lower, int k);

}  // namespace vantage
