#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "common/result.h"
#include "common/so3.h"

namespace vantage {

/// The rotations that map an object onto itself: a finite set, or all rotations about an axis with
/// or without the half turns that flip it. Axes pass through the model's `center`.
struct SymmetryGroup {
  enum class Kind { kFinite, kContinuous };

  Kind kind = Kind::kFinite;
  /// Finite: every element, the identity first. Continuous: unused.
  std::vector<Eigen::Quaterniond> elements = {Eigen::Quaterniond::Identity()};
  /// Continuous: the unit axis in the object's frame.
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  /// Continuous: half turns about axes perpendicular to `axis` map the object onto itself too.
  bool flips = false;

  static SymmetryGroup None() { return {}; }
  /// Rotations by 2 pi / order about `axis`; order in 1..1000.
  static SymmetryGroup Cyclic(int order, const Eigen::Vector3d& axis);
  /// Cyclic, and the half turns about `order` axes perpendicular to it, the first of them
  /// `half_turn_axis` (a brick without markings: Dihedral(2)).
  static SymmetryGroup Dihedral(int order,
                                const Eigen::Vector3d& axis,
                                const Eigen::Vector3d& half_turn_axis);
  static SymmetryGroup Continuous(const Eigen::Vector3d& axis, bool flips);
};

/// Angle between two orientations of an object modulo its symmetry, rad in [0, pi]:
/// min over s in the group of GeodesicAngle(a * s, b).
double SymmetricAngle(const SymmetryGroup& group,
                      const Eigen::Quaterniond& a,
                      const Eigen::Quaterniond& b);

/// Of all orientations equivalent to `q` the one nearest to `reference`.
Eigen::Quaterniond NearestEquivalent(const SymmetryGroup& group,
                                     const Eigen::Quaterniond& q,
                                     const Eigen::Quaterniond& reference);

}  // namespace vantage
