#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "common/so3.h"
#include "common/triangle_mesh.h"

namespace vantage {

/// The relation of two oriented points that no rigid motion changes (paper eq. 1).
struct PointPairFeature {
  float distance = 0.0F;       ///< m, |d|, d = m2 - m1
  float angle_normal1 = 0.0F;  ///< rad in [0, pi], angle(n1, d)
  float angle_normal2 = 0.0F;  ///< rad in [0, pi], angle(n2, d)
  float angle_normals = 0.0F;  ///< rad in [0, pi], angle(n1, n2)
};

/// Paper eq. 1. The angles to d are 0 when the points coincide.
PointPairFeature ComputePointPairFeature(const SurfacePoint& first, const SurfacePoint& second);

/// The transform that brings a point to the origin and its normal onto the x axis (Drost et al.
/// 2010, section 3.3): all that is left between two surfaces that share the point is a turn about
/// x.
Eigen::Isometry3f AlignToXAxis(const SurfacePoint& point);

/// Turn about x, rad in [-pi, pi], that brings AlignToXAxis(reference) * `other` into the half
/// plane y > 0, z = 0.
float AngleAboutX(const Eigen::Isometry3f& T_aligned, const Eigen::Vector3f& other);

}  // namespace vantage
