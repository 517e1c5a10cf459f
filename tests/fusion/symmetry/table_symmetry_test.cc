#include "fusion/symmetry/table_symmetry.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <vector>

#include "common/rng.h"
#include "common/so3.h"
#include "fusion/confusion/direction_grid.h"
#include "fusion/so3_grid.h"
#include "fusion/symmetry/symmetry_weights.h"

namespace vantage {
namespace {

constexpr int kDirections = 100;
constexpr int kTrials = 60;

// The truth turned by whatever a detector takes for it, seen from a direction.
using Detector = std::function<Eigen::Quaterniond(const Eigen::Vector3d&, Rng&)>;

ContingencyTable TableOf(const Detector& detect, double noise_deg = 0.5) {
  Rng rng(3);
  const DirectionGrid grid(kDirections);
  ContingencyTable table;
  table.key.model_id = "synthetic";
  table.key.num_directions = kDirections;
  for (int i = 0; i < kDirections; ++i) {
    std::map<std::array<int16_t, 3>, int32_t> counts;
    for (int trial = 0; trial < kTrials; ++trial) {
      const Eigen::Quaterniond noise =
          ExpSo3(std::abs(noise_deg * rng.Normal()) * kDegree * rng.UnitVector());
      ++counts[DifferenceCount::StepsOf(detect(grid.Center(i), rng) * noise)];
    }
    DirectionTrials direction{kTrials, 0, {}};
    for (const auto& [steps, count] : counts) direction.differences.push_back({steps, count});
    table.directions.push_back(direction);
  }
  return table;
}

Detector AnyOf(const SymmetryGroup& group) {
  return [group](const Eigen::Vector3d&, Rng& rng) {
    return group.elements[rng.Below(static_cast<uint32_t>(group.elements.size()))];
  };
}

void ExpectGroup(const SymmetryGroup& expected, double noise_deg = 0.5) {
  const Result<FoundSymmetry> found = SymmetryOfTable(TableOf(AnyOf(expected), noise_deg));
  ASSERT_TRUE(found.ok()) << found.error().message;
  EXPECT_EQ(found->group.kind, SymmetryGroup::Kind::kFinite);
  EXPECT_EQ(found->group.elements.size(), expected.elements.size());
  for (const Eigen::Quaterniond& element : found->group.elements) {
    EXPECT_LT(SymmetricAngle(expected, Eigen::Quaterniond::Identity(), element), 1.5 * kDegree);
  }
  EXPECT_TRUE(found->confusions.empty());
  EXPECT_GE(found->confidence, 0.9);
}

TEST(TableSymmetry, FindsTheGroupOfWhichTheDetectorPicksAtRandom) {
  const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX();
  const Eigen::Vector3d tilted = Eigen::Vector3d(0.3, -0.5, 0.8).normalized();
  ExpectGroup(SymmetryGroup::None());
  ExpectGroup(SymmetryGroup::Cyclic(2, tilted));
  ExpectGroup(SymmetryGroup::Cyclic(3, z));
  ExpectGroup(SymmetryGroup::Cyclic(4, tilted));
  ExpectGroup(SymmetryGroup::Cyclic(6, z), 3.0);
  ExpectGroup(SymmetryGroup::Dihedral(2, z, x));
  ExpectGroup(SymmetryGroup::Dihedral(4, tilted, tilted.unitOrthogonal()));
}

Eigen::Quaterniond About(const Eigen::Vector3d& axis, Rng& rng) {
  return ExpSo3(rng.Uniform(-std::numbers::pi, std::numbers::pi) * axis);
}

TEST(TableSymmetry, RotationsAlongACircleAreContinuous) {
  const Eigen::Vector3d axis = Eigen::Vector3d(0.2, 0.9, -0.4).normalized();
  const auto turns = [axis](const Eigen::Vector3d&, Rng& rng) { return About(axis, rng); };
  Result<FoundSymmetry> found = SymmetryOfTable(TableOf(turns));
  ASSERT_TRUE(found.ok()) << found.error().message;
  EXPECT_EQ(found->group.kind, SymmetryGroup::Kind::kContinuous);
  EXPECT_FALSE(found->group.flips);
  EXPECT_LT(found->group.axis.cross(axis).norm(), std::sin(1.0 * kDegree));
  EXPECT_TRUE(found->confusions.empty());

  const Eigen::Quaterniond flip = ExpSo3(std::numbers::pi * axis.unitOrthogonal());
  found = SymmetryOfTable(TableOf([&](const Eigen::Vector3d&, Rng& rng) {
    const Eigen::Quaterniond turn = About(axis, rng);
    return rng.Below(2) == 0 ? turn : turn * flip;
  }));
  ASSERT_TRUE(found.ok()) << found.error().message;
  EXPECT_EQ(found->group.kind, SymmetryGroup::Kind::kContinuous);
  EXPECT_TRUE(found->group.flips);
  EXPECT_LT(found->group.axis.cross(axis).norm(), std::sin(1.0 * kDegree));
}

TEST(TableSymmetry, RotationsOfEveryKindAreASphere) {
  TableSymmetryParameters parameters;
  parameters.k = 4;  // So few trials leave holes in finer grids.
  const auto any = [](const Eigen::Vector3d&, Rng& rng) { return rng.Rotation(); };
  const Result<FoundSymmetry> found = SymmetryOfTable(TableOf(any), parameters);
  ASSERT_TRUE(found.ok()) << found.error().message;
  EXPECT_TRUE(found->is_sphere);
}

TEST(TableSymmetry, WhatOccursFromHalfOfTheDirectionsIsAConfusionWithItsShare) {
  // A boss on the side of +x tells the half turn about z apart wherever it is seen.
  const Eigen::Quaterniond half_turn(0.0, 0.0, 0.0, 1.0);
  const Result<FoundSymmetry> found =
      SymmetryOfTable(TableOf([&](const Eigen::Vector3d& direction, Rng& rng) {
        const bool is_turned = direction.x() < 0.0 && rng.Below(2) == 0;
        return is_turned ? half_turn : Eigen::Quaterniond::Identity();
      }));
  ASSERT_TRUE(found.ok()) << found.error().message;
  EXPECT_EQ(found->group.elements.size(), 1U);
  EXPECT_TRUE(found->axes.empty());
  ASSERT_EQ(found->confusions.size(), 1U);
  EXPECT_LT(GeodesicAngle(found->confusions[0].rotation, half_turn), 1.0 * kDegree);
  EXPECT_NEAR(found->confusions[0].share_of_directions, 0.5, 0.05);
  EXPECT_NEAR(found->confusions[0].weight, 0.25, 0.03);
  EXPECT_NE(FoundSymmetryText(*found).find("confusion"), std::string::npos);
}

TEST(TableSymmetry, RefusesWhatSaysNothing) {
  EXPECT_FALSE(SymmetryOfTable({}).ok());
  ContingencyTable nothing;
  nothing.directions.resize(10);
  EXPECT_FALSE(SymmetryOfTable(nothing).ok());
  using P = TableSymmetryParameters;
  EXPECT_TRUE(P{}.Validate().ok());
  EXPECT_FALSE(P{.k = 1}.Validate().ok());
  EXPECT_FALSE(P{.heavy = 0.0}.Validate().ok());
  EXPECT_FALSE(P{.least_weight = 1.0}.Validate().ok());
  EXPECT_FALSE(P{.directions = std::nan("")}.Validate().ok());
}

TEST(SymmetryWeights, OfATableAreSharesAndSumToOne) {
  const So3Grid grid(8);
  const ContingencyTable table = TableOf(AnyOf(SymmetryGroup::Cyclic(2, Eigen::Vector3d::UnitZ())));
  const auto weights = TableSymmetryWeights(table, grid);
  ASSERT_TRUE(weights.ok());
  double sum = 0.0;
  double near_identity = 0.0;
  for (const auto& [cell, weight] : *weights) {
    sum += weight;
    const double angle = GeodesicAngle(grid.Representative(cell), Eigen::Quaterniond::Identity());
    if (angle < 0.5 * std::numbers::pi) near_identity += weight;
  }
  EXPECT_NEAR(sum, 1.0, 1e-9);
  EXPECT_NEAR(near_identity, 0.5, 0.03);
}

TEST(SymmetryWeights, OfRowsAreTheDifferencesOfTheirOrientations) {
  // Eq. 12 by hand: one row, detected as its own cell and as another.
  const So3Grid grid(4);
  std::vector<So3Grid::Cell> cells;  // By ordinal.
  grid.CellsAt(0, grid.num_cells(), &cells);
  ContingencyTable table;
  table.key.rows_k = 4;
  table.rows[100] = {4, 0, {{100, 3}, {700, 1}}};
  const auto weights = TableSymmetryWeights(table, grid);
  ASSERT_TRUE(weights.ok());
  const So3Grid::Cell none = grid.CellOf(Eigen::Quaterniond::Identity());
  const So3Grid::Cell other =
      grid.CellOf(grid.Representative(cells[100]).conjugate() * grid.Representative(cells[700]));
  ASSERT_EQ(weights->size(), 2U);
  for (const auto& [cell, weight] : *weights) {
    EXPECT_TRUE(cell == none || cell == other);
    EXPECT_DOUBLE_EQ(weight, cell == none ? 0.75 : 0.25);
  }
}

TEST(SymmetryWeights, OfRowsOfAHalfTurnAreAtTheHalfTurn) {
  const So3Grid grid(8);
  const Eigen::Quaterniond half_turn = ExpSo3(std::numbers::pi * Eigen::Vector3d::UnitZ());
  ContingencyTable table;
  table.key.rows_k = grid.k();
  Rng rng(5);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Quaterniond truth = rng.Rotation();
    RowTrials row;
    row.trials = 10;
    row.detected = {{grid.Ordinal(grid.CellOf(truth * half_turn)), 10}};
    table.rows[grid.Ordinal(grid.CellOf(truth))] = row;
  }
  const Result<std::vector<SymmetryWeight>> weights = TableSymmetryWeights(table, grid);
  ASSERT_TRUE(weights.ok()) << weights.error().message;
  double near = 0.0;
  double sum = 0.0;
  for (const SymmetryWeight& one : *weights) {
    sum += one.weight;
    // Two cells' errors.
    if (GeodesicAngle(grid.Representative(one.cell), half_turn) < 25.0 * kDegree)
      near += one.weight;
  }
  EXPECT_NEAR(sum, 1.0, 1e-9);
  EXPECT_GT(near, 0.95);
}

}  // namespace
}  // namespace vantage
