#include "common/symmetry_group.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "common/rng.h"

namespace vantage {
namespace {

constexpr double kPi = std::numbers::pi;
const Eigen::Vector3d kAxis = Eigen::Vector3d(1.0, 2.0, -0.5).normalized();

// Every element of a group; of a continuous one as many as make steps of `step` rad.
std::vector<Eigen::Quaterniond> Elements(const SymmetryGroup& group, double step) {
  if (group.kind == SymmetryGroup::Kind::kFinite) return group.elements;
  std::vector<Eigen::Quaterniond> elements;
  const Eigen::Quaterniond flip = ExpSo3(kPi * group.axis.unitOrthogonal());
  for (double angle = 0.0; angle < 2.0 * kPi; angle += step) {
    elements.push_back(ExpSo3(angle * group.axis));
    if (group.flips) elements.push_back(elements.back() * flip);
  }
  return elements;
}

std::vector<SymmetryGroup> Groups() {
  return {SymmetryGroup::None(),
          SymmetryGroup::Cyclic(1, kAxis),
          SymmetryGroup::Cyclic(2, kAxis),
          SymmetryGroup::Cyclic(5, kAxis),
          SymmetryGroup::Dihedral(1, kAxis, kAxis.unitOrthogonal()),
          SymmetryGroup::Dihedral(2, kAxis, kAxis.unitOrthogonal()),
          SymmetryGroup::Dihedral(3, kAxis, kAxis.unitOrthogonal()),
          SymmetryGroup::Continuous(kAxis, false),
          SymmetryGroup::Continuous(kAxis, true)};
}

TEST(SymmetryGroup, FiniteGroupsAreGroups) {
  const std::vector<SymmetryGroup> groups = Groups();
  const std::vector<size_t> sizes = {1, 1, 2, 5, 2, 4, 6};
  for (size_t i = 0; i < sizes.size(); ++i) {
    const std::vector<Eigen::Quaterniond>& elements = groups[i].elements;
    ASSERT_EQ(elements.size(), sizes[i]);
    EXPECT_EQ(GeodesicAngle(elements.front(), Eigen::Quaterniond::Identity()), 0.0);
    for (const Eigen::Quaterniond& a : elements) {
      for (const Eigen::Quaterniond& b : elements) {
        const auto hits =
            std::count_if(elements.begin(), elements.end(), [&](const Eigen::Quaterniond& c) {
              return GeodesicAngle(a.conjugate() * b, c) < 1e-12;
            });
        EXPECT_EQ(hits, 1) << "group " << i;
      }
    }
  }
}

TEST(SymmetricAngle, IsTheLeastOverAllElements) {
  Rng rng(1);
  constexpr double kStep = 0.001;
  for (const SymmetryGroup& group : Groups()) {
    const std::vector<Eigen::Quaterniond> elements = Elements(group, kStep);
    for (int i = 0; i < 20; ++i) {
      const Eigen::Quaterniond a = rng.Rotation();
      const Eigen::Quaterniond b = rng.Rotation();
      double least = kPi;
      for (const Eigen::Quaterniond& s : elements) {
        least = std::min(least, GeodesicAngle(a * s, b));
      }
      const double angle = SymmetricAngle(group, a, b);
      EXPECT_LE(angle, least + 1e-12);
      EXPECT_GE(angle, least - kStep);
      // Symmetric in its arguments, since groups hold inverses.
      EXPECT_NEAR(SymmetricAngle(group, b, a), angle, 1e-10);
    }
  }
}

TEST(SymmetricAngle, IsZeroAcrossTheGroup) {
  Rng rng(2);
  for (const SymmetryGroup& group : Groups()) {
    const Eigen::Quaterniond a = rng.Rotation();
    for (const Eigen::Quaterniond& s : Elements(group, 0.3)) {
      EXPECT_LE(SymmetricAngle(group, a * s, a), 1e-12);
    }
  }
}

TEST(SymmetricAngle, IsExactNearZeroAndPi) {
  // Turns about the axis of a continuous group vanish; turns across it remain.
  const SymmetryGroup group = SymmetryGroup::Continuous(kAxis, false);
  const Eigen::Vector3d across = kAxis.unitOrthogonal();
  for (const double angle : {0.0, 1e-9, 1e-4, 1.0, kPi - 1e-9, kPi}) {
    const Eigen::Quaterniond tilted = ExpSo3(angle * across) * ExpSo3(0.8 * kAxis);
    EXPECT_NEAR(SymmetricAngle(group, Eigen::Quaterniond::Identity(), tilted), angle, 1e-12);
  }
  const SymmetryGroup flipping = SymmetryGroup::Continuous(kAxis, true);
  for (const double angle : {kPi, kPi - 1e-9, kPi - 0.2}) {
    const Eigen::Quaterniond tilted = ExpSo3(angle * across) * ExpSo3(0.8 * kAxis);
    EXPECT_NEAR(
        SymmetricAngle(flipping, Eigen::Quaterniond::Identity(), tilted), kPi - angle, 1e-12);
  }
}

TEST(NearestEquivalent, IsEquivalentAndNearest) {
  Rng rng(3);
  for (const SymmetryGroup& group : Groups()) {
    for (int i = 0; i < 50; ++i) {
      const Eigen::Quaterniond q = rng.Rotation();
      const Eigen::Quaterniond reference = rng.Rotation();
      const Eigen::Quaterniond nearest = NearestEquivalent(group, q, reference);
      EXPECT_NEAR(nearest.norm(), 1.0, 1e-12);
      EXPECT_LE(SymmetricAngle(group, nearest, q), 1e-12);
      EXPECT_NEAR(GeodesicAngle(nearest, reference), SymmetricAngle(group, q, reference), 1e-12);
    }
  }
}

TEST(SymmetryGroup, DihedralTakesThePerpendicularPartOfItsHalfTurn) {
  const SymmetryGroup group =
      SymmetryGroup::Dihedral(2, Eigen::Vector3d::UnitZ(), {1.0, 0.0, 0.05});
  const Eigen::Quaterniond about_x = ExpSo3(kPi * Eigen::Vector3d::UnitX());
  EXPECT_LE(SymmetricAngle(group, about_x, Eigen::Quaterniond::Identity()), 1e-12);
}

}  // namespace
}  // namespace vantage
