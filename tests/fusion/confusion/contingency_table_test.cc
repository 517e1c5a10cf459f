#include "fusion/confusion/contingency_table.h"

#include <gtest/gtest.h>

#include <numbers>
#include <string>

#include "common/rng.h"
#include "common/so3.h"
#include "fusion/so3_grid.h"

namespace vantage {
namespace {

constexpr double kPi = std::numbers::pi;

ContingencyTable Part() {
  ContingencyTable part;
  part.key.model_id = "mug";
  part.key.estimator = "ppf";
  part.key.estimator_parameters = "a 1\nb 2\nc 3\n";
  part.key.num_directions = 3;
  part.key.rows_k = 8;
  return part;
}

DirectionTrials Trials(int trials, int missed) {
  DirectionTrials direction;
  direction.trials = trials;
  direction.missed = missed;
  if (trials > missed) direction.differences = {{{0, 0, 0}, trials - missed}};
  return direction;
}

TEST(DifferenceCount, LiesWithinAStepOfTheRotation) {
  Rng rng(1);
  for (int i = 0; i < 20'000; ++i) {
    Eigen::Quaterniond q = rng.Rotation();
    if (i % 4 == 1) q = ExpSo3(1e-3 * rng.Normal() * rng.UnitVector());
    if (i % 4 == 2) q = ExpSo3((kPi - 0.02 * rng.Uniform()) * rng.UnitVector());
    if (i % 4 == 3) q = ExpSo3((kPi - 1e-9) * rng.UnitVector());
    DifferenceCount count;
    count.steps = DifferenceCount::StepsOf(q);
    ASSERT_LE(GeodesicAngle(count.Difference(), q), 0.22 * kDegree);
    ASSERT_EQ(DifferenceCount::StepsOf(Eigen::Quaterniond(-q.coeffs())), count.steps);
    for (const int step : count.steps) ASSERT_LE(std::abs(step), 722);
  }
  EXPECT_EQ(DifferenceCount::StepsOf(Eigen::Quaterniond::Identity()),
            (std::array<int16_t, 3>{0, 0, 0}));
  EXPECT_EQ(DifferenceCount::StepsOf(ExpSo3({0.0, -1.0 * kDegree, 0.5 * kDegree})),
            (std::array<int16_t, 3>{0, -4, 2}));
}

TEST(DifferenceCount, HalfTurnsHaveOneWayToBeWritten) {
  Rng rng(2);
  for (int i = 0; i < 2000; ++i) {
    Eigen::Vector3d axis = rng.UnitVector();
    if (i < 3) axis = Eigen::Vector3d::Unit(i);
    const auto steps = DifferenceCount::StepsOf(ExpSo3(kPi * axis));
    const auto opposite = DifferenceCount::StepsOf(ExpSo3(-kPi * axis));
    EXPECT_EQ(steps, opposite) << axis.transpose();
    const auto before = DifferenceCount::StepsOf(ExpSo3((kPi - 1e-10) * axis));
    const auto behind = DifferenceCount::StepsOf(ExpSo3((kPi + 1e-10) * axis));
    EXPECT_EQ(before, behind) << axis.transpose();
  }
  EXPECT_EQ(DifferenceCount::StepsOf({0.0, 0.0, 0.0, 1.0}), (std::array<int16_t, 3>{0, 0, 720}));
  EXPECT_EQ(DifferenceCount::StepsOf({0.0, -1.0, 0.0, 0.0}), (std::array<int16_t, 3>{720, 0, 0}));
}

TEST(ContingencyTable, CountsItsTrials) {
  ContingencyTable table = Part();
  EXPECT_EQ(table.NumTrials(), 0);
  EXPECT_FALSE(table.IsComplete());
  table.directions = {Trials(2'000'000'000, 0), Trials(2'000'000'000, 3), Trials(0, 0)};
  EXPECT_EQ(table.NumTrials(), 4'000'000'000);
  EXPECT_FALSE(table.IsComplete());
  table.directions[2] = Trials(1, 1);
  EXPECT_TRUE(table.IsComplete());
  table.rows[5] = {10, 0, {{4, 10}}};
  EXPECT_EQ(table.NumTrials(), 4'000'000'011);
  ContingencyTable rows = Part();
  rows.key.num_directions = 0;
  EXPECT_TRUE(rows.IsComplete());
}

TEST(MergeTables, IsTheUnionInAnyOrder) {
  ContingencyTable a = Part();
  a.directions = {Trials(5, 1), {}, {}};
  a.rows[7] = {3, 0, {{1, 3}}};
  ContingencyTable b = Part();
  b.directions = {{}, {}, Trials(6, 6)};
  ContingencyTable c = Part();
  c.rows[2] = {4, 4, {}};
  ContingencyTable d = Part();
  d.directions = {Trials(5, 1), Trials(9, 0), {}};  // The same as in `a`, and more.
  const Result<ContingencyTable> merged = MergeTables({a, b, c, d});
  ASSERT_TRUE(merged.ok()) << merged.error().message;
  EXPECT_EQ(merged->directions[0], Trials(5, 1));
  EXPECT_EQ(merged->directions[1], Trials(9, 0));
  EXPECT_EQ(merged->directions[2], Trials(6, 6));
  EXPECT_EQ(merged->rows.size(), 2U);
  EXPECT_EQ(merged->rows.at(2).missed, 4);
  EXPECT_TRUE(merged->IsComplete());
  const Result<ContingencyTable> reversed = MergeTables({d, c, b, a});
  ASSERT_TRUE(reversed.ok());
  EXPECT_EQ(*reversed, *merged);
  EXPECT_EQ(*MergeTables({*merged, a}), *merged);
  EXPECT_EQ(*MergeTables({a}), a);
}

TEST(MergeTables, RefusesPartsThatDisagree) {
  ContingencyTable a = Part();
  a.directions = {Trials(5, 1), {}, {}};
  a.rows[7] = {3, 0, {{1, 3}}};
  ContingencyTable b = a;
  b.directions[0] = Trials(6, 1);
  Result<ContingencyTable> merged = MergeTables({a, b});
  ASSERT_FALSE(merged.ok());
  EXPECT_NE(merged.error().message.find("direction 0"), std::string::npos);
  EXPECT_NE(merged.error().message.find("5 trials"), std::string::npos);
  EXPECT_NE(merged.error().message.find("6"), std::string::npos);
  b = a;
  b.rows[7].detected[0].ordinal = 2;
  merged = MergeTables({a, b});
  ASSERT_FALSE(merged.ok());
  EXPECT_NE(merged.error().message.find("row 7"), std::string::npos);
  b = a;
  b.directions.resize(2);
  EXPECT_FALSE(MergeTables({a, b}).ok());
  EXPECT_FALSE(MergeTables({b}).ok());
  EXPECT_FALSE(MergeTables({}).ok());
}

TEST(MergeTables, NamesTheFieldOfTheKeyThatDiffers) {
  const auto message = [](auto&& change) {
    ContingencyTable b = Part();
    change(&b.key);
    const Result<ContingencyTable> merged = MergeTables({Part(), b});
    return merged.ok() ? std::string() : merged.error().message;
  };
  const auto expect = [&](const std::string& part, auto&& change) {
    const std::string text = message(change);
    EXPECT_NE(text.find(part), std::string::npos) << text;
  };
  expect("model is \"cup\", expected \"mug\"", [](ContingencyKey* k) { k->model_id = "cup"; });
  expect("mesh is \"ab\"", [](ContingencyKey* k) { k->mesh_hash = "ab"; });
  expect("estimator is \"shot\", expected \"ppf\"",
         [](ContingencyKey* k) { k->estimator = "shot"; });
  expect("\"b 7\", expected \"b 2\"",
         [](ContingencyKey* k) { k->estimator_parameters = "a 1\nb 7\nc 3\n"; });
  expect("\"\", expected \"c 3\"",
         [](ContingencyKey* k) { k->estimator_parameters = "a 1\nb 2\n"; });
  expect("\"a 11\", expected \"a 1\"",
         [](ContingencyKey* k) { k->estimator_parameters = "a 11\nb 2\nc 3\n"; });
  expect("sensor is \"x\"", [](ContingencyKey* k) { k->sensor = "x"; });
  expect("stopping is \"x\"", [](ContingencyKey* k) { k->stopping = "x"; });
  expect("seed is \"9\", expected \"1\"", [](ContingencyKey* k) { k->seed = 9; });
  expect("directions is 4, expected 3", [](ContingencyKey* k) { k->num_directions = 4; });
  expect("rows is 16, expected 8", [](ContingencyKey* k) { k->rows_k = 16; });
  EXPECT_TRUE(message([](ContingencyKey*) {}).empty());
}

}  // namespace
}  // namespace vantage
