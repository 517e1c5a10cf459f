#include "fusion/confusion/direction_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "common/so3.h"
#include "fusion/confusion/viewing_direction.h"

namespace vantage {
namespace {

const int kSizes[] = {2, 3, 4, 5, 6, 7, 10, 25, 100, 391, 1000, 6246, 100'000};

double Angle(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

TEST(DirectionGrid, CentersAreInTheirCells) {
  for (const int n : kSizes) {
    const DirectionGrid grid(n);
    ASSERT_EQ(grid.num_cells(), n);
    for (int cell = 0; cell < n; ++cell) {
      const Eigen::Vector3d center = grid.Center(cell);
      ASSERT_NEAR(center.norm(), 1.0, 1e-12);
      ASSERT_EQ(grid.CellOf(center), cell) << n;
      ASSERT_EQ(grid.CellOf(1e-6 * center), cell) << n;
      ASSERT_EQ(grid.CellOf(1e200 * center), cell) << n;
    }
  }
}

TEST(DirectionGrid, SamplesAreInTheirCells) {
  Rng rng(1);
  for (const int n : kSizes) {
    const DirectionGrid grid(n);
    const int draws = std::max(1, 20'000 / n);
    for (int cell = 0; cell < n; ++cell) {
      for (int i = 0; i < draws; ++i) {
        const Eigen::Vector3d direction = grid.Sample(cell, rng);
        ASSERT_NEAR(direction.norm(), 1.0, 1e-12);
        ASSERT_EQ(grid.CellOf(direction), cell) << n;
      }
    }
  }
}

// Uniform points fall into every cell equally often: chi squared of n - 1 degrees of freedom.
TEST(DirectionGrid, AreasAreEqual) {
  Rng rng(2);
  for (const int n : {2, 3, 7, 25, 100, 391}) {
    const DirectionGrid grid(n);
    std::vector<int> counts(static_cast<size_t>(n), 0);
    const int draws = 2000 * n;
    for (int i = 0; i < draws; ++i) ++counts[static_cast<size_t>(grid.CellOf(rng.UnitVector()))];
    double chi_squared = 0.0;
    for (const int count : counts) chi_squared += (count - 2000.0) * (count - 2000.0) / 2000.0;
    EXPECT_LT(chi_squared, (n - 1) + 5.0 * std::sqrt(2.0 * n) + 10.0) << n;
  }
}

// Samples are uniform: their mean is that of the whole sphere's points of the cell.
TEST(DirectionGrid, SamplesAreUniformOverTheCell) {
  const DirectionGrid grid(10);
  std::vector<Eigen::Vector3d> of_sphere(10, Eigen::Vector3d::Zero());
  std::vector<int> counts(10, 0);
  Rng rng(3);
  for (int i = 0; i < 400'000; ++i) {
    const Eigen::Vector3d direction = rng.UnitVector();
    const auto cell = static_cast<size_t>(grid.CellOf(direction));
    of_sphere[cell] += direction;
    ++counts[cell];
  }
  for (int cell = 0; cell < 10; ++cell) {
    Eigen::Vector3d of_samples = Eigen::Vector3d::Zero();
    for (int i = 0; i < 40'000; ++i) of_samples += grid.Sample(cell, rng);
    const Eigen::Vector3d difference =
        of_samples / 40'000.0 -
        of_sphere[static_cast<size_t>(cell)] / counts[static_cast<size_t>(cell)];
    EXPECT_LT(difference.norm(), 0.015) << cell;
  }
}

// Cells are compact: nothing is farther from its cell's center than 7 / sqrt(n) (Leopardi 2006
// finds diameters of at most that).
TEST(DirectionGrid, CellsAreCompact) {
  Rng rng(4);
  for (const int n : {4, 25, 391, 6246, 100'000}) {
    const DirectionGrid grid(n);
    for (int i = 0; i < 20'000; ++i) {
      const Eigen::Vector3d direction = rng.UnitVector();
      const double angle = Angle(direction, grid.Center(grid.CellOf(direction)));
      ASSERT_LE(2.0 * std::sin(0.5 * angle), 0.5 * 7.0 / std::sqrt(n)) << n;
    }
  }
}

TEST(DirectionGrid, PolesEquatorAndSeamHaveACell) {
  for (const int n : kSizes) {
    const DirectionGrid grid(n);
    EXPECT_EQ(grid.CellOf({0.0, 0.0, 1.0}), 0);
    EXPECT_EQ(grid.CellOf({0.0, 0.0, -1.0}), n - 1);
    EXPECT_EQ(grid.CellOf({-0.0, 0.0, 5e-300}), 0);
    for (const double z : {-0.9999, -0.5, -0.0, 0.0, 1e-300, 0.5, 0.9999}) {
      // Both ways to come to the seams at pi and 0 end in cells that hold their surroundings.
      const int at_pi = grid.CellOf({-1.0, 0.0, z});
      EXPECT_EQ(grid.CellOf({-1.0, 1e-9, z}) == at_pi || grid.CellOf({-1.0, -1e-9, z}) == at_pi,
                true);
      EXPECT_EQ(grid.CellOf({-1.0, -0.0, z}), at_pi);
      EXPECT_EQ(grid.CellOf({1.0, -0.0, z}), grid.CellOf({1.0, 0.0, z}));
      EXPECT_EQ(grid.CellOf({1.0, 1e-9, z}), grid.CellOf({1.0, 0.0, z}));
      const int below = grid.CellOf({1.0, -std::numeric_limits<double>::min(), z});
      EXPECT_TRUE(below >= 0 && below < n);
    }
  }
}

TEST(DirectionGrid, CellsWithinAreThoseOfBruteForce) {
  Rng rng(5);
  for (const int n : {2, 3, 7, 100, 391}) {
    const DirectionGrid grid(n);
    for (int i = 0; i < 200; ++i) {
      Eigen::Vector3d direction = 3.0 * rng.UnitVector();
      if (i == 0) direction = {0.0, 0.0, 1.0};
      if (i == 1) direction = {0.0, 0.0, -2.0};
      if (i == 2) direction = {-1.0, 0.0, 0.0};
      double radius = rng.Uniform(0.0, i % 2 == 0 ? 0.3 : 3.3);
      if (i % 20 == 3) radius = 0.0;
      if (i % 20 == 4) radius = std::numbers::pi;
      if (i % 20 == 5) radius = 0.5 * std::numbers::pi;
      std::vector<int> expected;
      for (int cell = 0; cell < n; ++cell) {
        if (Angle(direction.normalized(), grid.Center(cell)) <= radius) expected.push_back(cell);
      }
      ASSERT_EQ(grid.CellsWithin(direction, radius), expected) << n << " " << radius;
    }
    EXPECT_EQ(grid.CellsWithin(grid.Center(n / 2), 1e-9), std::vector<int>{n / 2});
  }
}

// The centers lie as far apart as Table 1 says of the grid's orientations.
TEST(DirectionGrid, NumDirectionsFollowsTheOrientationGrid) {
  EXPECT_EQ(NumDirections(8), 391);
  EXPECT_EQ(NumDirections(16), 1562);
  EXPECT_EQ(NumDirections(32), 6246);
  EXPECT_LE(NumDirections(128), DirectionGrid::kMost);
  EXPECT_GE(NumDirections(2), DirectionGrid::kFewest);
  const DirectionGrid grid(NumDirections(8));
  double sum = 0.0;
  for (int cell = 0; cell < grid.num_cells(); ++cell) {
    double nearest = 10.0;
    for (int other = 0; other < grid.num_cells(); ++other) {
      if (other != cell) nearest = std::min(nearest, Angle(grid.Center(cell), grid.Center(other)));
    }
    sum += nearest;
  }
  EXPECT_NEAR(sum / grid.num_cells() / kDegree, 10.28, 1.0);
}

TEST(ViewingDirection, IsWhatTheOrientationWasMadeFor) {
  Rng rng(6);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d direction =
        i == 0 ? Eigen::Vector3d(0.0, 0.0, 1.0)
               : (i == 1 ? Eigen::Vector3d(0.0, 0.0, -1.0) : rng.UnitVector());
    const double roll = rng.Uniform(-4.0, 4.0);
    const Eigen::Quaterniond q = OrientationSeenFrom(direction, roll);
    EXPECT_LT((ViewingDirection(q) - direction).norm(), 1e-9);
    // Rolling the camera leaves it, and the rolls differ by their angle.
    EXPECT_NEAR(GeodesicAngle(q, OrientationSeenFrom(direction, roll + 0.5)), 0.5, 1e-9);
  }
}

}  // namespace
}  // namespace vantage
