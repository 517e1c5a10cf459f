#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "common/so3.h"
#include "common/triangle_mesh.h"

namespace vantage {

// The larger of the generated objects, one function each: m, x forward, y left, base at z = 0.

// Vessels, of lofted rings.
TriangleMesh Pitcher();
TriangleMesh Sauce();
TriangleMesh Spray();

// Figures, of implicit solids.
TriangleMesh Cat();
TriangleMesh Dwarf();
TriangleMesh Fish();
TriangleMesh Pony();
TriangleMesh Turtle();

// Of a symmetry that one small feature breaks.
TriangleMesh Brick();
TriangleMesh Cap();
TriangleMesh Cross();
TriangleMesh Flange();
TriangleMesh Knob();
TriangleMesh Nut();
TriangleMesh Plug();
TriangleMesh Reel();
TriangleMesh Star();
TriangleMesh Valve();

/// A shift, m.
inline Pose At(double x, double y, double z) { return Pose(Eigen::Translation3d(x, y, z)); }

/// A turn, rad.
inline Pose Turned(double angle, const Eigen::Vector3d& axis) {
  return Pose(Eigen::AngleAxisd(angle, axis));
}

}  // namespace vantage
