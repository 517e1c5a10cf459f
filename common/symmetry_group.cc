#include "common/symmetry_group.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "common/check.h"

namespace vantage {
namespace {

// The rotation about `axis` that brings `q` nearest to `reference`: the swing-twist decomposition
// of the difference, keeping the twist.
Eigen::Quaterniond BestTwist(const Eigen::Quaterniond& q,
                             const Eigen::Quaterniond& reference,
                             const Eigen::Vector3d& axis) {
  const Eigen::Quaterniond difference = q.conjugate() * reference;
  const double along = difference.vec().dot(axis);
  const double norm = std::hypot(difference.w(), along);
  if (norm < 1e-15) return q;  // A half turn across the axis: every twist is as near.
  Eigen::Quaterniond twist;
  twist.w() = difference.w() / norm;
  twist.vec() = axis * (along / norm);
  return (q * twist).normalized();
}

}  // namespace

SymmetryGroup SymmetryGroup::Cyclic(int order, const Eigen::Vector3d& axis) {
  VANTAGE_CHECK(order >= 1 && order <= 1000, "order of a symmetry group");
  SymmetryGroup group;
  group.axis = axis.normalized();
  group.elements.clear();
  for (int i = 0; i < order; ++i) {
    group.elements.push_back(ExpSo3(group.axis * (2.0 * std::numbers::pi * i / order)));
  }
  return group;
}

SymmetryGroup SymmetryGroup::Dihedral(int order,
                                      const Eigen::Vector3d& axis,
                                      const Eigen::Vector3d& half_turn_axis) {
  SymmetryGroup group = Cyclic(order, axis);
  const Eigen::Vector3d perpendicular =
      (half_turn_axis - half_turn_axis.dot(group.axis) * group.axis).normalized();
  const Eigen::Quaterniond half_turn = ExpSo3(std::numbers::pi * perpendicular);
  for (int i = 0; i < order; ++i) {
    group.elements.push_back(group.elements[static_cast<size_t>(i)] * half_turn);
  }
  return group;
}

SymmetryGroup SymmetryGroup::Continuous(const Eigen::Vector3d& axis, bool flips) {
  SymmetryGroup group;
  group.kind = Kind::kContinuous;
  group.axis = axis.normalized();
  group.flips = flips;
  return group;
}

Eigen::Quaterniond NearestEquivalent(const SymmetryGroup& group,
                                     const Eigen::Quaterniond& q,
                                     const Eigen::Quaterniond& reference) {
  Eigen::Quaterniond best;
  double least = std::numeric_limits<double>::infinity();
  const auto consider = [&](const Eigen::Quaterniond& candidate) {
    const double angle = GeodesicAngle(candidate, reference);
    if (angle < least) {
      least = angle;
      best = candidate;
    }
  };
  if (group.kind == SymmetryGroup::Kind::kFinite) {
    VANTAGE_CHECK(!group.elements.empty(), "a symmetry group without the identity");
    best = q * group.elements.front();
    for (const Eigen::Quaterniond& element : group.elements) consider(q * element);
  } else {
    best = BestTwist(q, reference, group.axis);
    consider(best);
    if (group.flips) {
      const Eigen::Quaterniond flip = ExpSo3(std::numbers::pi * group.axis.unitOrthogonal());
      consider(BestTwist(q * flip, reference, group.axis));
    }
  }
  return best;
}

double SymmetricAngle(const SymmetryGroup& group,
                      const Eigen::Quaterniond& a,
                      const Eigen::Quaterniond& b) {
  return GeodesicAngle(NearestEquivalent(group, a, b), b);
}

}  // namespace vantage
