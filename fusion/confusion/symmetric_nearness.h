#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "common/symmetry_group.h"

namespace vantage {

/// cos(angle / 2) of the angle between two orientations of an object modulo its symmetry:
/// SymmetricAngle without its trigonometry, for the many comparisons of which most are far apart.
/// In [0, 1] but for rounding; `a` and `b` of norm 1.
inline double SymmetricNearness(const SymmetryGroup& group,
                                const Eigen::Quaterniond& a,
                                const Eigen::Quaterniond& b) {
  // |<a g, b>| = |<g, a^* b>|.
  const Eigen::Quaterniond difference = a.conjugate() * b;
  if (group.kind == SymmetryGroup::Kind::kContinuous) {
    const double along = difference.vec().dot(group.axis);
    const double turned = std::hypot(difference.w(), along);
    if (!group.flips) return turned;
    return std::max(turned, (difference.vec() - along * group.axis).norm());
  }
  double nearest = 0.0;
  for (const Eigen::Quaterniond& element : group.elements) {
    nearest = std::max(nearest, std::abs(element.dot(difference)));
  }
  return nearest;
}

/// The angle in rad that a nearness stands for.
inline double AngleOfNearness(double nearness) { return 2.0 * std::acos(std::min(1.0, nearness)); }

}  // namespace vantage
