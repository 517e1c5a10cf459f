#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <variant>
#include <vector>

#include "common/so3.h"
#include "common/triangle_mesh.h"

namespace vantage {

/// A ball of a limb's skeleton.
struct Ball {
  Eigen::Vector3d center;  ///< m
  double radius;           ///< m
};

/// A free form standing on the plane z = 0: the union of limbs and ellipsoids, rounded off where
/// they meet (skeletal implicit surface, Bloomenthal 1997). What lies below the plane is cut off.
class ImplicitSolid {
 public:
  /// The balls, each joined to the next by the cone about both; none inside its neighbor.
  /// @param blend m, width of the fillet to all that was added before; 0 for none
  void AddLimb(std::vector<Ball> balls, double blend);
  /// @param radii m, along the axes of its own frame
  void AddEllipsoid(const Pose& T_solid_ellipsoid, const Eigen::Vector3d& radii, double blend);

  /// Distance to the surface, m, negative inside: exact next to a limb, to first order next to an
  /// ellipsoid (Taubin 1994).
  [[nodiscard]] double Distance(const Eigen::Vector3d& point) const;

  /// A closed mesh, by surface nets (Gibson 1998): a vertex in each grid cell that the surface
  /// passes through, moved onto the surface. @param cell m, edge of a grid cell
  [[nodiscard]] TriangleMesh Polygonize(double cell) const;

 private:
  struct Ellipsoid {
    Pose T_ellipsoid_solid;
    Eigen::Vector3d radii;
  };
  struct Part {
    std::variant<std::vector<Ball>, Ellipsoid> shape;
    double blend;
  };
  static double DistanceTo(const std::vector<Ball>& balls, const Eigen::Vector3d& point);
  static double DistanceTo(const Ellipsoid& ellipsoid, const Eigen::Vector3d& point);
  [[nodiscard]] Eigen::Vector3d Gradient(const Eigen::Vector3d& point) const;

  std::vector<Part> parts_;
  Eigen::AlignedBox3d bounds_;
};

}  // namespace vantage
