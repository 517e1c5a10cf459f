#include "fusion/confusion/accuracy_weights.h"

#include <gtest/gtest.h>

#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "common/rng.h"
#include "common/so3.h"
#include "fusion/confusion/viewing_direction.h"
#include "tests/fusion/confusion/synthetic_object.h"

namespace vantage {
namespace {

constexpr double kTrials = AccuracyWeights::kTrials;

AccuracyWeights Made(Result<AccuracyWeights> weights) {
  EXPECT_TRUE(weights.ok()) << weights.error().message;
  return std::move(weights).value();
}

SyntheticObject Object() {
  SyntheticObject object;
  object.error = 2.0 * kDegree;
  object.outliers = 0.05;
  return object;
}

ContingencyTable MeasuredRows(const So3Grid& grid, int every, Rng& rng) {
  ContingencyTable table;
  table.key.rows_k = grid.k();
  const SyntheticObject object = Object();
  const std::vector<So3Grid::Cell> cells = grid.ValidCells();
  for (size_t i = 0; i < cells.size(); i += static_cast<size_t>(every)) {
    std::map<int32_t, int> counts;
    RowTrials row;
    row.trials = i % 2 == 0 ? 250 : 50;
    for (int trial = 0; trial < row.trials; ++trial) {
      ++counts[grid.Ordinal(grid.CellOf(*object.Detect(grid.Representative(cells[i]), rng)))];
    }
    for (const auto& [ordinal, count] : counts) row.detected.push_back({ordinal, count});
    table.rows[static_cast<int32_t>(i)] = row;
  }
  return table;
}

// CT(i, d) of rows, as it is written.
double RowCount(const ContingencyTable& table, int32_t truth, int32_t detected) {
  const auto row = table.rows.find(truth);
  if (row == table.rows.end()) return 0.0;
  for (const RowTrials::Count& count : row->second.detected) {
    if (count.ordinal == detected) return kTrials * count.count / row->second.trials;
  }
  return 0.0;
}

// Every cell of the histogram is compared with the table's own definition, and the mass with the
// sum over all of them.
template <class CountOf>
void ExpectColumn(AccuracyWeights& weights,
                  const So3Grid& grid,
                  Rng& rng,
                  const CountOf& count_of) {
  const std::vector<So3Grid::Cell> cells = grid.ValidCells();
  size_t num_counted = 0;
  for (int view = 0; view < 12; ++view) {
    const Eigen::Quaterniond q_world_camera =
        view == 0 ? Eigen::Quaterniond::Identity() : rng.Rotation();
    const Eigen::Quaterniond detected = rng.Rotation();
    OrientationHistogram histogram(grid);
    weights.AddTo(q_world_camera, detected, 0.7, &histogram);
    std::vector<double> expected;
    double sum = 0.0;
    for (const So3Grid::Cell cell : cells) {
      const double count = count_of(q_world_camera.conjugate() * grid.Representative(cell),
                                    q_world_camera.conjugate() * detected);
      if (count > 0.0) ++num_counted;
      expected.push_back(count + AccuracyWeights::kPseudoCount);
      sum += expected.back() * grid.Area(cell);
    }
    for (size_t i = 0; i < cells.size(); ++i) {
      const double weight = 0.7 * expected[i] / sum;
      ASSERT_NEAR(histogram.Weight(cells[i]), weight, 1e-5 * weight) << view << ", " << i;
    }
    EXPECT_NEAR(histogram.Mass(), 0.7, 1e-6);
  }
  EXPECT_GT(num_counted, 20U);
}

TEST(AccuracyWeights, OfRowsAreEquation9InEveryCell) {
  const So3Grid grid(8);
  Rng rng(31);
  const ContingencyTable table = MeasuredRows(grid, 3, rng);
  AccuracyWeights weights = Made(AccuracyWeights::FromRows(table, grid));
  ExpectColumn(
      weights, grid, rng, [&](const Eigen::Quaterniond& truth, const Eigen::Quaterniond& detected) {
        return RowCount(
            table, grid.Ordinal(grid.CellOf(truth)), grid.Ordinal(grid.CellOf(detected)));
      });
}

// CT(i, d) by direction, as it is written.
double DirectionCount(const ContingencyTable& table,
                      const DirectionGrid& directions,
                      const So3Grid& grid,
                      const Eigen::Quaterniond& truth,
                      So3Grid::Cell detected) {
  const DirectionTrials& trials =
      table.directions[static_cast<size_t>(directions.CellOf(ViewingDirection(truth)))];
  double count = 0.0;
  for (const DifferenceCount& difference : trials.differences) {
    if (grid.CellOf(truth * difference.Difference()) != detected) continue;
    count += kTrials * difference.count / trials.trials;
  }
  return count;
}

TEST(AccuracyWeights, ByDirectionAreEquation9OfThePapersTableInEveryCell) {
  Rng rng(32);
  for (const int k : {4, AccuracyWeights::kLargestFull}) {
    const So3Grid grid(k);
    for (const int num_directions : {2, 3, 7, 391}) {
      const ContingencyTable table = Object().Measure(num_directions, 60, 33);
      const DirectionGrid directions(num_directions);
      AccuracyWeights weights = Made(AccuracyWeights::FromDirections(table, grid));
      ExpectColumn(weights,
                   grid,
                   rng,
                   [&](const Eigen::Quaterniond& truth, const Eigen::Quaterniond& detected) {
                     return DirectionCount(table,
                                           directions,
                                           grid,
                                           grid.Representative(grid.CellOf(truth)),
                                           grid.CellOf(detected));
                   });
    }
  }
}

TEST(AccuracyWeights, ByDirectionAreEquation9InEveryCellOfAFineGrid) {
  Rng rng(36);
  const So3Grid grid(AccuracyWeights::kLargestFull + 1);
  for (const int num_directions : {2, 7, 391}) {
    const ContingencyTable table = Object().Measure(num_directions, 40, 33);
    const DirectionGrid directions(num_directions);
    AccuracyWeights weights = Made(AccuracyWeights::FromDirections(table, grid));
    ExpectColumn(weights,
                 grid,
                 rng,
                 [&](const Eigen::Quaterniond& truth, const Eigen::Quaterniond& detected) {
                   return DirectionCount(table, directions, grid, truth, grid.CellOf(detected));
                 });
  }
}

// The emptier a detection's column, the less of its mass is at truths, and the smaller c_p is, the
// less that matters.
TEST(AccuracyWeights, PseudoCountTakesTheMassOfColumnsThatAreNearlyEmpty) {
  const So3Grid grid(8);
  ContingencyTable table;
  table.directions.resize(2);
  SyntheticObject::Count(Eigen::Quaterniond::Identity(), &table.directions[0], 250);
  SyntheticObject::Count(Eigen::Quaterniond::Identity(), &table.directions[1], 5);
  table.directions[1].trials = 250;
  table.directions[1].missed = 245;
  const auto heaviest = [&](const Eigen::Vector3d& direction, double c_p) {
    AccuracyWeights weights = Made(AccuracyWeights::FromDirections(table, grid, c_p));
    OrientationHistogram histogram(grid);
    weights.AddTo(
        Eigen::Quaterniond::Identity(), OrientationSeenFrom(direction, 0.4), 1.0, &histogram);
    return static_cast<double>(histogram.weights().Largest());
  };
  const Eigen::Vector3d full = Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d empty = -full;
  EXPECT_NEAR(heaviest(full, 6.0) / heaviest(empty, 6.0), 50.0, 1.0);  // As the counts.
  EXPECT_LT(heaviest(full, 1e-4) / heaviest(empty, 1e-4), 2.0);        // Both are certain.
}

TEST(AccuracyWeights, RefuseWhatIsNoTable) {
  const So3Grid grid(4);
  Rng rng(34);
  const ContingencyTable rows = MeasuredRows(grid, 5, rng);
  const ContingencyTable directions = Object().Measure(10, 20, 35);
  EXPECT_TRUE(AccuracyWeights::FromRows(rows, grid).ok());
  EXPECT_FALSE(AccuracyWeights::FromRows(rows, So3Grid(8)).ok());
  EXPECT_FALSE(AccuracyWeights::FromRows(directions, grid).ok());
  EXPECT_FALSE(AccuracyWeights::FromDirections(rows, grid).ok());
  for (const double bad : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_FALSE(AccuracyWeights::FromRows(rows, grid, bad).ok());
    EXPECT_FALSE(AccuracyWeights::FromDirections(directions, grid, bad).ok());
  }
  for (const int32_t bad : {-1, grid.num_cells()}) {
    ContingencyTable table = rows;
    table.rows.begin()->second.detected.front().ordinal = bad;
    EXPECT_FALSE(AccuracyWeights::FromRows(table, grid).ok());
    ContingencyTable truth = rows;
    truth.rows[bad] = rows.rows.begin()->second;
    EXPECT_FALSE(AccuracyWeights::FromRows(truth, grid).ok());
  }
  for (const int32_t bad : {-1, 0, 1000}) {
    ContingencyTable table = rows;
    table.rows.begin()->second.detected.front().count = bad;
    EXPECT_FALSE(AccuracyWeights::FromRows(table, grid).ok());
    ContingencyTable other = directions;
    other.directions[3].differences.front().count = bad;
    EXPECT_FALSE(AccuracyWeights::FromDirections(other, grid).ok());
  }
}

}  // namespace
}  // namespace vantage
