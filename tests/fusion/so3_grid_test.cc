#include "fusion/so3_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "common/rng.h"
#include "common/so3.h"

namespace vantage {
namespace {

TEST(So3Grid, NumberOfCellsIsThePapers) {
  EXPECT_EQ(So3Grid(8).num_cells(), 8480);
  EXPECT_EQ(So3Grid(16).num_cells(), 68416);
  EXPECT_EQ(So3Grid(32).num_cells(), 548496);
  for (const int k : {2, 3, 5, 8, 13}) {
    const So3Grid grid(k);
    EXPECT_EQ(static_cast<size_t>(grid.num_cells()), grid.ValidCells().size()) << k;
  }
}

TEST(So3Grid, AreasSumToOne) {
  for (const int k : {2, 3, 5, 8, 10, 16}) {
    const So3Grid grid(k);
    double sum = 0.0;
    int num_empty = 0;
    for (const So3Grid::Cell cell : grid.ValidCells()) {
      sum += grid.Area(cell);
      num_empty += grid.Area(cell) == 0.0 ? 1 : 0;
    }
    EXPECT_NEAR(sum, 1.0, 1e-11) << k;
    if (k == 8) {
      EXPECT_EQ(num_empty, 16);  // The cells that open cells would lack.
    }
  }
}

// Areas and centroids against random orientations binned by their cell.
TEST(So3Grid, PatchesMatchMonteCarlo) {
  struct Sum {
    int count = 0;
    Eigen::Vector4d moment = Eigen::Vector4d::Zero();
  };
  const So3Grid grid(3);
  std::map<So3Grid::Cell, Sum> sums;
  Rng rng(7);
  constexpr int kSamples = 2'000'000;
  for (int i = 0; i < kSamples; ++i) {
    const Eigen::Quaterniond q = Canonical(rng.Rotation());
    Sum& sum = sums[grid.CellOf(q)];
    ++sum.count;
    sum.moment += q.coeffs();
  }
  for (const So3Grid::Cell cell : grid.ValidCells()) {
    const double area = grid.Area(cell);
    const Sum& sum = sums[cell];
    const double sigma = std::sqrt(area * (1.0 - area) * kSamples);
    EXPECT_NEAR(sum.count, area * kSamples, 5.0 * sigma + 1e-9) << cell;
    if (sum.count < 2000) continue;
    const Eigen::Quaterniond centroid(sum.moment.normalized());
    EXPECT_LT(GeodesicAngle(grid.Representative(cell), centroid) / kDegree,
              150.0 / std::sqrt(static_cast<double>(sum.count)))
        << cell;
  }
}

// One patch against a fine lattice of the sphere: relative error 1e-6.
TEST(So3Grid, PatchMatchesDenseIntegration) {
  constexpr int k = 4;
  for (const std::array<int, 4>& lower :
       {std::array<int, 4>{0, 0, 0, 3}, {1, 2, 2, 2}, {0, 1, 2, 3}, {0, 0, 2, 3}}) {
    const SpherePatch patch = IntegrateSpherePatch(lower, k);
    // Over x, y by the midpoint rule; along the circle that remains by a fine scan of its angle.
    constexpr int kSteps = 60;
    constexpr int kAngles = 2000;
    double area = 0.0;
    Eigen::Vector4d moment = Eigen::Vector4d::Zero();
    for (int i = 0; i < kSteps; ++i) {
      for (int j = 0; j < kSteps; ++j) {
        const double x = (lower[0] + (i + 0.5) / kSteps) / k;
        const double y = (lower[1] + (j + 0.5) / kSteps) / k;
        const double rest = 1.0 - x * x - y * y;
        if (rest <= 0.0) continue;
        for (int n = 0; n < kAngles; ++n) {
          const double angle = 0.5 * M_PI * (n + 0.5) / kAngles;
          const double z = std::sqrt(rest) * std::cos(angle);
          const double w = std::sqrt(rest) * std::sin(angle);
          if (std::floor(z * k) != lower[2] || std::floor(w * k) != lower[3]) continue;
          const double weight = 0.5 * M_PI / kAngles / (kSteps * kSteps * k * k);
          area += weight;
          moment += weight * Eigen::Vector4d(x, y, z, w);
        }
      }
    }
    EXPECT_NEAR(patch.area, area / (M_PI * M_PI), 2e-3 * patch.area);
    EXPECT_LT((patch.centroid - moment.normalized()).norm(), 1e-4);
  }
}

TEST(So3Grid, RepresentativeLiesInItsOwnCell) {
  const So3Grid grid(16);
  for (const So3Grid::Cell cell : grid.ValidCells()) {
    ASSERT_NEAR(grid.Representative(cell).norm(), 1.0, 1e-12);
    if (grid.Area(cell) == 0.0) continue;
    ASSERT_EQ(grid.CellOf(grid.Representative(cell)), cell);
  }
}

TEST(So3Grid, NearestNeighborsAreAtThePapersDistance) {
  const So3Grid grid(8);
  std::vector<Eigen::Vector4d> representatives;
  for (const So3Grid::Cell cell : grid.ValidCells()) {
    if (grid.Area(cell) > 0.0) representatives.push_back(grid.Representative(cell).coeffs());
  }
  double sum = 0.0;
  double square_sum = 0.0;
  for (size_t i = 0; i < representatives.size(); ++i) {
    double largest = 0.0;
    for (size_t j = 0; j < representatives.size(); ++j) {
      if (i != j) largest = std::max(largest, std::abs(representatives[i].dot(representatives[j])));
    }
    const double angle = 2.0 * std::acos(std::min(1.0, largest)) / kDegree;
    sum += angle;
    square_sum += angle * angle;
  }
  const auto count = static_cast<double>(representatives.size());
  const double mean = sum / count;
  EXPECT_NEAR(mean, 10.28, 0.05);  // Table 1 of the paper.
  EXPECT_NEAR(std::sqrt(square_sum / count - mean * mean), 1.40, 0.03);
}

TEST(So3Grid, CellOfIsTheSameForBothQuaternionsOfAnOrientation) {
  Rng rng(1);
  for (const int k : {2, 8, 31, 128}) {
    const So3Grid grid(k);
    for (int i = 0; i < 20000; ++i) {
      Eigen::Quaterniond q = rng.Rotation();
      if (i % 4 == 0) q.w() = 0.0;
      if (i % 8 == 0) q.z() = 0.0;
      if (i % 16 == 0) q.y() = 0.0;
      q.normalize();
      const So3Grid::Cell cell = grid.CellOf(q);
      ASSERT_TRUE(grid.IsValid(cell));
      ASSERT_EQ(cell, grid.CellOf(Eigen::Quaterniond(-q.coeffs())));
    }
  }
}

TEST(So3Grid, CellsAtTheLatticesCornersAreValid) {
  const So3Grid grid(8);
  for (const double s : {-1.0, 1.0}) {
    for (int axis = 0; axis < 4; ++axis) {
      Eigen::Vector4d coefficients = Eigen::Vector4d::Zero();
      coefficients[axis] = s;
      EXPECT_TRUE(grid.IsValid(grid.CellOf(Eigen::Quaterniond(coefficients))));
    }
    EXPECT_TRUE(grid.IsValid(grid.CellOf(Eigen::Quaterniond(0.5, 0.5 * s, 0.5, -0.5))));
  }
  EXPECT_FALSE(grid.IsValid(-1));
  EXPECT_FALSE(grid.IsValid(8 * 8 * 8 * 8 * 8));
  EXPECT_FALSE(grid.IsValid(0));  // The lattice's far corner.
}

TEST(So3Grid, NeighborsAreMutual) {
  for (const int k : {2, 3, 8}) {
    const So3Grid grid(k);
    std::vector<So3Grid::Cell> neighbors;
    std::vector<So3Grid::Cell> back;
    for (const So3Grid::Cell cell : grid.ValidCells()) {
      grid.Neighbors(cell, &neighbors);
      ASSERT_GE(neighbors.size(), 4U);
      for (const So3Grid::Cell neighbor : neighbors) {
        ASSERT_NE(neighbor, cell);
        ASSERT_TRUE(grid.IsValid(neighbor));
        grid.Neighbors(neighbor, &back);
        ASSERT_TRUE(std::binary_search(back.begin(), back.end(), cell));
      }
    }
  }
}

TEST(So3Grid, NeighborsCrossHalfTurns) {
  const So3Grid grid(16);
  const Eigen::Vector3d axis = Eigen::Vector3d(0.31, -0.52, 0.79).normalized();
  const So3Grid::Cell before = grid.CellOf(ExpSo3((M_PI - 0.01) * axis));
  const So3Grid::Cell after = grid.CellOf(ExpSo3((M_PI + 0.01) * axis));
  ASSERT_NE(before, after);
  std::vector<So3Grid::Cell> neighbors;
  grid.Neighbors(before, &neighbors);
  EXPECT_TRUE(std::binary_search(neighbors.begin(), neighbors.end(), after));
}

TEST(So3Grid, CellsWithinEqualsSearchingAllCells) {
  Rng rng(3);
  for (const int k : {2, 5, 8}) {
    const So3Grid grid(k);
    const std::vector<So3Grid::Cell> all = grid.ValidCells();
    for (int i = 0; i < 60; ++i) {
      Eigen::Quaterniond q = rng.Rotation();
      if (i % 3 == 0) q.w() = 0.0;
      if (i % 7 == 0) q = Eigen::Quaterniond(0.0, 0.0, 1.0, 0.0);
      q.normalize();
      const double radius = i == 1 ? M_PI : rng.Uniform(0.02, 1.8);
      std::vector<So3Grid::NearCell> near;
      grid.CellsWithin(q, radius, &near);
      std::vector<So3Grid::Cell> expected;
      for (const So3Grid::Cell cell : all) {
        if (GeodesicAngle(q, grid.Representative(cell)) <= radius) expected.push_back(cell);
      }
      ASSERT_EQ(near.size(), expected.size()) << "k " << k << " radius " << radius;
      for (size_t n = 0; n < near.size(); ++n) {
        ASSERT_EQ(near[n].cell, expected[n]);
        ASSERT_NEAR(near[n].angle, GeodesicAngle(q, grid.Representative(near[n].cell)), 1e-9);
      }
    }
  }
}

TEST(So3Grid, LargestGridFitsItsNumbers) {
  const So3Grid grid(So3Grid::kLargest);
  EXPECT_NEAR(grid.num_cells(), 548496 * 64, 548496);
  Rng rng(5);
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Quaterniond q = rng.Rotation();
    const So3Grid::Cell cell = grid.CellOf(q);
    EXPECT_GE(cell, 0);
    EXPECT_LT(GeodesicAngle(q, grid.Representative(cell)), 2.0 * kDegree);
  }
}

}  // namespace
}  // namespace vantage
