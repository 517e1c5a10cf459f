#pragma once

#include <Eigen/Core>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include "common/triangle_mesh.h"

namespace vantage {

// Closed bodies with outward winding, from which the bundled objects are put together. Metres.

/// A closed line of points in space.
using Ring = std::vector<Eigen::Vector3d>;

/// The body between rings of equal size, each joined to the next; the first and the last are closed
/// by fans about their mean, so those must be star-shaped about it. Seen from the last ring towards
/// the first one the points go counter-clockwise. At least two rings of three points.
TriangleMesh Loft(std::span<const Ring> rings);

/// A body of revolution about z. @param profile (r, z), from the lower end on the axis (r = 0)
/// round the outside to the upper end on the axis; only its ends touch the axis.
TriangleMesh Revolve(std::span<const Eigen::Vector2d> profile, int segments);

/// A ring in the plane z: cross-section of an ellipse-like bottle, |x/a|^n + |y/b|^n = 1.
Ring SuperellipseRing(double a, double b, double exponent, double z, int points);

/// A ring in the plane z: rectangle of full size x by y with its corners rounded.
Ring RoundedRectangleRing(double x, double y, double radius, double z, int points_per_corner);

/// A ring in the plane z from radius as a function of angle.
template <class RadiusOfAngle>
Ring PolarRing(RadiusOfAngle radius, double z, int points) {
  Ring ring;
  for (int i = 0; i < points; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / points;
    const double r = radius(angle);
    ring.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
  }
  return ring;
}

/// Upright cylinder about z from z0 to z1, its edges beveled by `bevel`.
TriangleMesh Cylinder(double radius, double z0, double z1, double bevel, int segments);

/// Box of size x, y, z with its base at z = 0, centred in x and y, edges beveled by `bevel`.
TriangleMesh BeveledBox(const Eigen::Vector3d& size, double bevel);

/// Ellipsoid about the origin.
TriangleMesh Ellipsoid(const Eigen::Vector3d& radii, int segments);

/// A bent rod of round cross-section along a path of at least two points in a plane of normal
/// `plane_normal`, closed at its ends.
TriangleMesh Rod(std::span<const Eigen::Vector3d> path,
                 const Eigen::Vector3d& plane_normal,
                 double radius,
                 int segments);

/// A wedge: right triangle with legs along +x (`length`) and +z (`height`) extruded over y,
/// centred in y.
TriangleMesh Wedge(double length, double height, double width);

}  // namespace vantage
