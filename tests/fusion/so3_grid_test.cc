#include "fusion/so3_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "common/rng.h"
#include "common/so3.h"
#include "fusion/sphere_patch.h"

namespace vantage {
namespace {

bool Contains(const std::vector<So3Grid::Neighbor>& neighbors, So3Grid::Cell cell) {
  return std::any_of(neighbors.begin(), neighbors.end(), [cell](const So3Grid::Neighbor& neighbor) {
    return neighbor.cell == cell;
  });
}

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
    std::vector<So3Grid::Neighbor> neighbors;
    std::vector<So3Grid::Neighbor> back;
    for (const So3Grid::Cell cell : grid.ValidCells()) {
      grid.Neighbors(cell, &neighbors);
      ASSERT_GE(neighbors.size(), 4U);
      std::set<So3Grid::Cell> once;
      for (const So3Grid::Neighbor& neighbor : neighbors) {
        ASSERT_NE(neighbor.cell, cell);
        ASSERT_TRUE(grid.IsValid(neighbor.cell));
        ASSERT_EQ(neighbor.ordinal, grid.Ordinal(neighbor.cell));
        ASSERT_TRUE(once.insert(neighbor.cell).second);
        grid.Neighbors(neighbor.cell, &back);
        ASSERT_TRUE(Contains(back, cell));
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
  std::vector<So3Grid::Neighbor> neighbors;
  grid.Neighbors(before, &neighbors);
  EXPECT_TRUE(Contains(neighbors, after));
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
      std::sort(
          near.begin(), near.end(), [](const auto& a, const auto& b) { return a.cell < b.cell; });
      for (size_t n = 0; n < near.size(); ++n) {
        ASSERT_EQ(near[n].cell, expected[n]);
        ASSERT_EQ(near[n].ordinal, grid.Ordinal(near[n].cell));
        ASSERT_EQ(near[n].area, grid.Area(near[n].cell));
        const double angle = GeodesicAngle(q, grid.Representative(near[n].cell));
        ASSERT_NEAR(near[n].squared_angle, angle * angle, 1e-6);
      }
    }
  }
}

TEST(So3Grid, OrdinalsCountTheValidCells) {
  for (const int k : {2, 3, 7, 8, 16}) {
    const So3Grid grid(k);
    std::vector<So3Grid::Cell> by_ordinal;
    grid.CellsAt(0, grid.num_cells(), &by_ordinal);
    ASSERT_EQ(by_ordinal.size(), static_cast<size_t>(grid.num_cells()));
    std::vector<So3Grid::Cell> run;
    for (int32_t i = 0; i < grid.num_cells(); ++i) {
      ASSERT_EQ(grid.Ordinal(by_ordinal[static_cast<size_t>(i)]), i);
      if (i % 37 != 0) continue;
      const int32_t count = std::min(3, grid.num_cells() - i);
      grid.CellsAt(i, count, &run);
      ASSERT_TRUE(std::equal(run.begin(), run.end(), by_ordinal.begin() + i));
    }
    std::sort(by_ordinal.begin(), by_ordinal.end());
    EXPECT_EQ(by_ordinal, grid.ValidCells());
  }
}

TEST(So3Grid, OutOfRangeIsAnError) {
  for (const int k : {-1, 0, 1, 129, 1 << 30}) {
    const Result<So3Grid> grid = So3Grid::Create(k);
    ASSERT_FALSE(grid.ok()) << k;
    EXPECT_NE(grid.error().message.find("expected 2..128"), std::string::npos);
  }
  EXPECT_TRUE(So3Grid::Create(2).ok());
}

// A finer grid than can be searched for all: some representatives against all 68,416.
TEST(So3Grid, NearestNeighborsAreFoundAmongAllCells) {
  const So3Grid grid(16);
  std::vector<So3Grid::Cell> cells;
  grid.CellsAt(0, grid.num_cells(), &cells);
  std::vector<Eigen::Vector4d> all;
  for (const So3Grid::Cell cell : cells) all.push_back(grid.Representative(cell).coeffs());
  Rng rng(8);
  for (int i = 0; i < 200; ++i) {
    const size_t own = rng.Below(static_cast<uint32_t>(cells.size()));
    if (grid.Area(cells[own]) == 0.0) continue;
    double largest = 0.0;
    size_t nearest = own;
    for (size_t j = 0; j < all.size(); ++j) {
      const double dot = std::abs(all[own].dot(all[j]));
      if (j == own || dot <= largest || grid.Area(cells[j]) == 0.0) continue;
      largest = dot;
      nearest = j;
    }
    const double angle =
        GeodesicAngle(Eigen::Quaterniond(all[own]), Eigen::Quaterniond(all[nearest]));
    EXPECT_GT(angle, 0.4 * 5.12 * kDegree);
    EXPECT_LT(angle, 1.6 * 5.12 * kDegree);
    // The search from there finds itself and, as far as the nearest one, nothing else.
    std::vector<So3Grid::NearCell> near;
    grid.CellsWithin(Eigen::Quaterniond(-all[own]), angle * (1.0 + 1e-6), &near);
    std::erase_if(near, [](const So3Grid::NearCell& cell) { return cell.area == 0.0; });
    EXPECT_TRUE(std::any_of(
        near.begin(), near.end(), [&](const auto& cell) { return cell.cell == cells[nearest]; }));
    grid.CellsWithin(Eigen::Quaterniond(all[own]), angle * (1.0 - 1e-6), &near);
    std::erase_if(near, [](const So3Grid::NearCell& cell) { return cell.area == 0.0; });
    ASSERT_EQ(near.size(), 1U);
    EXPECT_EQ(near.front().cell, cells[own]);
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
