#include "fusion/confusion/held_out.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <vector>

#include "common/rng.h"
#include "common/so3.h"
#include "fusion/confusion/predicted_row.h"

namespace vantage {
namespace {

RowTrials Row(int missed, const std::map<int32_t, int32_t>& counts) {
  RowTrials row;
  row.missed = row.trials = missed;
  for (const auto& [ordinal, count] : counts) {
    row.detected.push_back({ordinal, count});
    row.trials += count;
  }
  return row;
}

// Every outcome by itself: their probabilities sum to 1.
TEST(HeldOutLogLikelihood, IsThatOfADistribution) {
  const RowTrials row = Row(3, {{2, 5}, {7, 1}});
  for (const double a : {1e-3, 0.1, 2.0}) {
    double sum = std::exp(HeldOutLogLikelihood(row, Row(1, {}), 10, a));
    for (int cell = 0; cell < 10; ++cell) {
      sum += std::exp(HeldOutLogLikelihood(row, Row(0, {{cell, 1}}), 10, a));
    }
    EXPECT_NEAR(sum, 1.0, 1e-12) << a;
  }
}

TEST(HeldOutLogLikelihood, IsTheMeanOverTrials) {
  const RowTrials row = Row(3, {{2, 5}, {7, 1}});
  const double all = 9.0 + 0.5 * 11.0;
  const double expected =
      (2.0 * std::log(3.5 / all) + 4.0 * std::log(5.5 / all) + 3.0 * std::log(0.5 / all)) / 9.0;
  EXPECT_NEAR(
      HeldOutLogLikelihood(row, Row(2, {{2, 4}, {3, 1}, {9, 2}}), 10, 0.5), expected, 1e-12);
  EXPECT_EQ(HeldOutLogLikelihood(row, RowTrials(), 10, 0.5), 0.0);
  // Nothing known: uniform.
  EXPECT_NEAR(HeldOutLogLikelihood({}, row, 10, 0.5), -std::log(11.0), 1e-12);
}

TEST(LeaveOneOutPseudoCount, IsTheLikeliestOfAll) {
  Rng rng(1);
  std::vector<RowTrials> rows;
  for (int i = 0; i < 20; ++i) {
    std::map<int32_t, int32_t> counts;
    for (int j = 0; j < 50; ++j) {
      const bool known = rng.Uniform() < 0.9;
      ++counts[static_cast<int32_t>(known ? rng.Below(3) : rng.Below(1000))];
    }
    rows.push_back(Row(2, counts));
  }
  const double best = LeaveOneOutPseudoCount(rows, 1000);
  // By taking each trial out of its row and asking for its likelihood.
  const auto likelihood = [&](double a) {
    double sum = 0.0;
    for (const RowTrials& row : rows) {
      for (size_t j = 0; j < row.detected.size(); ++j) {
        RowTrials rest = row;
        --rest.detected[j].count;
        --rest.trials;
        RowTrials one = Row(0, {{row.detected[j].ordinal, 1}});
        sum += row.detected[j].count * HeldOutLogLikelihood(rest, one, 1000, a);
      }
      RowTrials rest = row;
      --rest.missed;
      --rest.trials;
      sum += row.missed * HeldOutLogLikelihood(rest, Row(1, {}), 1000, a);
    }
    return sum;
  };
  for (double a = 1e-6; a < 1.0; a *= 1.3) EXPECT_LE(likelihood(a), likelihood(best) + 1e-3) << a;
}

TEST(LeaveOneOutPseudoCount, StaysWithinItsBounds) {
  const std::vector<RowTrials> sure(5, Row(0, {{1, 100}}));
  EXPECT_LT(LeaveOneOutPseudoCount(sure, 1000), 2e-6);
  std::vector<RowTrials> scattered;
  for (int i = 0; i < 5; ++i) scattered.push_back(Row(0, {{i, 1}, {i + 10, 1}, {i + 20, 1}}));
  EXPECT_GT(LeaveOneOutPseudoCount(scattered, 1000), 0.9);
  const double nothing = LeaveOneOutPseudoCount({}, 1000);
  EXPECT_TRUE(nothing >= 1e-6 && nothing <= 1.0);
}

// Outcomes that do not depend on the roll: a direction's trials foretell a row as well as trials of
// that row; and worse when the other distribution is told.
TEST(HeldOutLogLikelihood, ADirectionForetellsARowAsWellAsTheRow) {
  const So3Grid grid(8);
  Rng rng(2);
  const auto draw = [&](double flipped) {
    const Eigen::Quaterniond mode =
        rng.Uniform() < flipped ? Eigen::Quaterniond(0, 0, 0, 1) : Eigen::Quaterniond::Identity();
    const Eigen::Vector3d error(rng.Normal(), rng.Normal(), rng.Normal());
    return mode * ExpSo3(1.0 * kDegree * error);
  };
  const auto trials = [&](double flipped) {
    std::map<std::array<int16_t, 3>, int32_t> counts;
    for (int i = 0; i < 250; ++i) ++counts[DifferenceCount::StepsOf(draw(flipped))];
    DirectionTrials direction;
    direction.trials = 250;
    for (const auto& [steps, count] : counts) direction.differences.push_back({steps, count});
    return direction;
  };
  const auto row = [&](double flipped, const Eigen::Quaterniond& q_truth) {
    std::map<int32_t, int32_t> counts;
    for (int i = 0; i < 250; ++i) ++counts[grid.Ordinal(grid.CellOf(q_truth * draw(flipped)))];
    return Row(0, counts);
  };
  double by_row = 0.0;
  double by_direction = 0.0;
  double by_other = 0.0;
  for (int i = 0; i < 40; ++i) {
    const Eigen::Quaterniond q_truth = rng.Rotation();
    const RowTrials held_out = row(0.3, q_truth);
    const auto likelihood = [&](const RowTrials& model) {
      return HeldOutLogLikelihood(model, held_out, grid.num_cells(), 1e-3) / 40;
    };
    by_row += likelihood(row(0.3, q_truth));
    by_direction += likelihood(PredictedRow(trials(0.3), grid, q_truth));
    by_other += likelihood(PredictedRow(trials(0.9), grid, q_truth));
  }
  EXPECT_NEAR(by_row, by_direction, 0.03);
  EXPECT_LT(by_other, by_row - 0.3);
}

}  // namespace
}  // namespace vantage
