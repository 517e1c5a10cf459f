#include "fusion/confusion/confusion_model.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "common/so3.h"
#include "fusion/confusion/viewing_direction.h"
#include "tests/fusion/confusion/synthetic_object.h"

namespace vantage {
namespace {

ConfusionModel Made(const ContingencyTable& table,
                    const SymmetryGroup& symmetry = SymmetryGroup::None(),
                    const ConfusionModelParameters& parameters = {}) {
  Result<ConfusionModel> model = ConfusionModel::Make(table, symmetry, parameters);
  EXPECT_TRUE(model.ok()) << model.error().message;
  return std::move(model).value();
}

Eigen::Quaterniond TurnZ(double degrees) {
  return ExpSo3(degrees * kDegree * Eigen::Vector3d::UnitZ());
}

// Two directions, z and -z, without smoothing.
ContingencyTable TwoDirections() {
  ContingencyTable table;
  table.key.num_directions = 2;
  table.directions.resize(2);
  SyntheticObject::Count(TurnZ(0.0), &table.directions[0], 60);
  SyntheticObject::Count(TurnZ(90.0), &table.directions[0], 30);
  table.directions[0].missed = 10;
  table.directions[0].trials += 10;
  SyntheticObject::Count(TurnZ(1.0), &table.directions[1], 50);
  SyntheticObject::Count(TurnZ(180.0), &table.directions[1], 50);
  return table;
}

ConfusionModelParameters Unsmoothed() {
  ConfusionModelParameters parameters;
  parameters.direction_smoothing = 0.0;
  return parameters;
}

void ExpectSharesSumToOne(const ConfusionModel& model) {
  for (int i = 0; i < model.num_directions(); ++i) {
    double sum = model.Missed(i);
    int previous = -1;
    for (const ConfusionModel::Share& share : model.SharesFrom(i)) {
      EXPECT_GT(share.mode, previous);
      EXPECT_GT(share.share, 0.0);
      EXPECT_EQ(model.ShareFrom(i, share.mode), share.share);
      previous = share.mode;
      sum += share.share;
    }
    EXPECT_LT(previous, model.num_modes());
    ASSERT_NEAR(sum, 1.0, 1e-12);
    ASSERT_LE(model.Scattered(i), model.Missed(i));
  }
}

TEST(ConfusionModel, SharesAreThoseCounted) {
  const ConfusionModel model = Made(TwoDirections(), SymmetryGroup::None(), Unsmoothed());
  ASSERT_EQ(model.num_modes(), 3);
  EXPECT_EQ(model.Difference(0).coeffs(), Eigen::Quaterniond::Identity().coeffs());
  const int quarter = model.ModeOf(TurnZ(91.0));
  const int half = model.ModeOf(TurnZ(-178.0));
  ASSERT_GT(quarter, 0);
  ASSERT_GT(half, 0);
  EXPECT_EQ(model.ModeOf(TurnZ(5.9)), 0);
  EXPECT_EQ(model.ModeOf(TurnZ(6.1)), -1);
  EXPECT_DOUBLE_EQ(model.ShareFrom(0, 0), 0.6);
  EXPECT_DOUBLE_EQ(model.ShareFrom(0, quarter), 0.3);
  EXPECT_DOUBLE_EQ(model.ShareFrom(0, half), 0.0);
  EXPECT_NEAR(model.Missed(0), 0.1, 1e-12);
  EXPECT_NEAR(model.Scattered(0), 0.0, 1e-12);
  EXPECT_DOUBLE_EQ(model.ShareFrom(1, 0), 0.5);
  EXPECT_DOUBLE_EQ(model.ShareFrom(1, half), 0.5);
  EXPECT_EQ(model.num_unmeasured(), 0);
  ExpectSharesSumToOne(model);
}

TEST(ConfusionModel, EntropyIsThatOfTheOutcomesWithOutliers) {
  const ConfusionModel model = Made(TwoDirections(), SymmetryGroup::None(), Unsmoothed());
  double entropy = 0.0;
  double sum = 0.0;
  for (const double share : {0.6, 0.3, 0.0, 0.1, 0.0}) {  // Three modes, nothing, scattered.
    const double p = 0.98 * share + 0.02 / 5.0;
    entropy -= p * std::log(p);
    sum += p;
  }
  EXPECT_NEAR(sum, 1.0, 1e-12);
  EXPECT_NEAR(model.Entropy(0), entropy, 1e-9);
}

TEST(ConfusionModel, FindsTheTurnsOfAnAmbiguousObject) {
  SyntheticObject object;
  object.outliers = 0.02;
  object.missed = 0.05;
  const ConfusionModel model = Made(object.Measure(391, 100, 3));
  ASSERT_EQ(model.num_modes(), 4);
  for (int turn = 0; turn < 4; ++turn) {
    const int mode = model.ModeOf(object.Turn(turn));
    ASSERT_GE(mode, 0);
    EXPECT_LT(GeodesicAngle(model.Difference(mode), object.Turn(turn)), 0.2 * kDegree);
    for (int i = 0; i < model.num_directions(); ++i) {
      const Eigen::Vector3d direction = model.directions().Center(i);
      if (std::abs(direction.x() - 0.2) < 0.3) continue;  // Mixed at the border.
      const double expected = 0.95 * 0.98 * object.Share(direction, turn);
      EXPECT_NEAR(model.ShareFrom(i, mode), expected, 0.18);
    }
  }
  ExpectSharesSumToOne(model);
  EXPECT_EQ(model.num_unmeasured(), 0);
}

TEST(ConfusionModel, DifferencesThatTheSymmetryMakesEqualAreOne) {
  const SyntheticObject object;
  const ContingencyTable table = object.Measure(100, 60, 5);
  EXPECT_EQ(Made(table).num_modes(), 4);
  const ConfusionModel half = Made(table, SymmetryGroup::Cyclic(2, Eigen::Vector3d::UnitZ()));
  ASSERT_EQ(half.num_modes(), 2);
  EXPECT_EQ(half.ModeOf(TurnZ(180.0)), 0);
  EXPECT_EQ(half.ModeOf(TurnZ(-90.0)), 1);
  EXPECT_NEAR(GeodesicAngle(half.Difference(1), TurnZ(0.0)), 90.0 * kDegree, 1.0 * kDegree);
  EXPECT_EQ(Made(table, SymmetryGroup::Cyclic(4, Eigen::Vector3d::UnitZ())).num_modes(), 1);
  const ConfusionModel round =
      Made(table, SymmetryGroup::Continuous(Eigen::Vector3d::UnitZ(), false));
  EXPECT_EQ(round.num_modes(), 1);
  EXPECT_GT(round.ShareFrom(0, 0), 0.999);
}

// Modulo the group on the right only: g^* q' is another orientation than q' unless q' turns one
// into the other.
TEST(ConfusionModel, DifferencesAreNotMergedOnTheLeft) {
  const Eigen::Quaterniond tilt = ExpSo3(40.0 * kDegree * Eigen::Vector3d::UnitX());
  ContingencyTable table;
  table.directions.resize(2);
  SyntheticObject::Count(tilt, &table.directions[0], 50);
  SyntheticObject::Count(TurnZ(180.0) * tilt, &table.directions[1], 50);
  const ConfusionModel model =
      Made(table, SymmetryGroup::Cyclic(2, Eigen::Vector3d::UnitZ()), Unsmoothed());
  ASSERT_EQ(model.num_modes(), 3);  // And the identity.
  EXPECT_NE(model.ModeOf(tilt), model.ModeOf(TurnZ(180.0) * tilt));
  EXPECT_EQ(model.ModeOf(tilt), model.ModeOf(tilt * TurnZ(180.0)));
}

TEST(ConfusionModel, DirectionIsThatOfTheViewWhateverTheRoll) {
  const ConfusionModel model = Made(SyntheticObject().Measure(391, 5, 1));
  Rng rng(2);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Quaterniond q = rng.Rotation();
    EXPECT_EQ(model.DirectionOf(q), model.directions().CellOf(ViewingDirection(q)));
    EXPECT_EQ(model.DirectionOf(TurnZ(rng.Uniform(0.0, 360.0)) * q), model.DirectionOf(q));
  }
}

TEST(ConfusionModel, UnmeasuredDirectionsTakeTheSharesOfTheNearest) {
  const SyntheticObject object;
  const ContingencyTable whole = object.Measure(391, 60, 7);
  ContingencyTable part = whole;
  for (size_t i = 0; i < part.directions.size(); i += 2) part.directions[i] = {};
  const ConfusionModel model = Made(part, SymmetryGroup::None(), Unsmoothed());
  EXPECT_EQ(model.num_unmeasured(), 196);
  ExpectSharesSumToOne(model);
  for (int i = 0; i < 391; i += 2) {
    const Eigen::Vector3d center = model.directions().Center(i);
    double largest = -1.0;
    for (int j = 1; j < 391; j += 2) {
      largest = std::max(largest, center.dot(model.directions().Center(j)));
    }
    bool same = false;  // As one of those that are as near.
    for (int j = 1; j < 391; j += 2) {
      same = same || (center.dot(model.directions().Center(j)) > largest - 1e-9 &&
                      model.ShareFrom(i, 0) == model.ShareFrom(j, 0));
    }
    EXPECT_TRUE(same) << i;
  }
}

TEST(ConfusionModel, SmoothingIsAMeanOverNeighborsByTheirTrials) {
  const ContingencyTable table = SyntheticObject().Measure(391, 20, 9);
  const ConfusionModel raw = Made(table, SymmetryGroup::None(), Unsmoothed());
  const ConfusionModel smooth = Made(table);
  const double sigma = ConfusionModelParameters().direction_smoothing;
  for (const int cell : {0, 17, 200, 390}) {
    double sum = 0.0;
    double weights = 0.0;
    for (int other = 0; other < 391; ++other) {
      const double angle = std::acos(
          std::min(1.0, raw.directions().Center(cell).dot(raw.directions().Center(other))));
      if (angle > 3.0 * sigma) continue;
      const double weight = std::exp(-0.5 * angle * angle / (sigma * sigma));
      sum += weight * raw.ShareFrom(other, 0);  // As many trials of each.
      weights += weight;
    }
    EXPECT_NEAR(smooth.ShareFrom(cell, 0), sum / weights, 1e-6);
  }
}

// Detections all over SO(3) are not right ones, nor modes: they are counted as telling nothing.
TEST(ConfusionModel, ScatteredDetectionsTellNothing) {
  ContingencyTable table;
  table.directions.resize(2);
  Rng rng(4);
  SyntheticObject::Count(TurnZ(0.0), &table.directions[0], 400);
  SyntheticObject::Count(TurnZ(0.0), &table.directions[1], 160);
  for (int i = 0; i < 240; ++i) SyntheticObject::Count(rng.Rotation(), &table.directions[1], 1);
  const ConfusionModel model = Made(table, SymmetryGroup::None(), Unsmoothed());
  EXPECT_NEAR(model.ShareFrom(1, 0), 0.4, 0.01);
  EXPECT_GT(model.Scattered(1), 0.5);
  EXPECT_EQ(model.Missed(0), 0.0);
  ExpectSharesSumToOne(model);
}

TEST(ConfusionModel, RefusesWhatIsNoTable) {
  const auto error_of = [](const ContingencyTable& table, ConfusionModelParameters parameters) {
    const Result<ConfusionModel> made =
        ConfusionModel::Make(table, SymmetryGroup::None(), parameters);
    return made.ok() ? std::string() : made.error().message;
  };
  const ConfusionModelParameters good;
  EXPECT_EQ(error_of(TwoDirections(), good), "");
  EXPECT_NE(error_of({}, good).find("0 viewing directions"), std::string::npos);
  ContingencyTable none;
  none.directions.resize(10);
  EXPECT_NE(error_of(none, good).find("no trials"), std::string::npos);
  for (const int change : {1, -1}) {
    ContingencyTable table = TwoDirections();
    table.directions[1].trials += change;
    EXPECT_NE(error_of(table, good).find("direction 1"), std::string::npos);
  }
  ContingencyTable negative = TwoDirections();
  negative.directions[0].differences[0].count = -5;
  EXPECT_NE(error_of(negative, good), "");
  for (const double bad : {-1.0, 0.0, 1.0e9, std::numeric_limits<double>::quiet_NaN()}) {
    ConfusionModelParameters radius;
    radius.mode_radius = bad;
    EXPECT_NE(error_of(TwoDirections(), radius).find("mode_radius"), std::string::npos);
    ConfusionModelParameters outliers;
    outliers.outlier_share = bad;
    EXPECT_NE(error_of(TwoDirections(), outliers).find("outlier_share"), std::string::npos);
    if (bad == 0.0) continue;
    ConfusionModelParameters smoothing;
    smoothing.direction_smoothing = bad;
    EXPECT_NE(error_of(TwoDirections(), smoothing).find("direction_smoothing"), std::string::npos);
  }
}

}  // namespace
}  // namespace vantage
