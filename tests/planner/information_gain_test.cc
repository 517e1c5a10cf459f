#include "planner/information_gain.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <vector>

#include "fusion/confusion/viewing_direction.h"
#include "tests/planner/planner_scenes.h"

namespace vantage {
namespace {

constexpr int kNothing = -1;
constexpr int kScattered = -2;

// Of an object at the origin, which the camera looks at.
double Information(const ConfusionModel& model,
                   const std::vector<OrientationHypothesis>& belief,
                   const Pose& T_world_camera,
                   double unhidden = 1.0) {
  return InformationGain(model, belief).From(-T_world_camera.linear().col(2), unhidden).information;
}

// Probability of every outcome by one hypothesis: outcomes are turns of `q`, told by their number.
std::map<int, double> Outcomes(const ConfusionModel& model,
                               const SyntheticObject& object,
                               const Eigen::Quaterniond& q,
                               const Eigen::Quaterniond& hypothesis,
                               const Pose& T_world_camera,
                               double unhidden) {
  const Eigen::Quaterniond q_camera_world(T_world_camera.linear().transpose());
  const int direction = model.DirectionOf(q_camera_world * hypothesis);
  std::map<int, double> outcomes;
  for (int mode = 0; mode < model.num_modes(); ++mode) {
    const Eigen::Quaterniond reported = hypothesis * model.Difference(mode);
    int number = -100;
    for (int turn = 0; turn < object.order; ++turn) {
      const double angle = SymmetricAngle(model.symmetry(), q * object.Turn(turn), reported);
      if (angle < 1.0 * kDegree && number < 0) number = turn;
    }
    EXPECT_GE(number, 0);
    outcomes[number] += unhidden * model.WithOutliers(model.ShareFrom(direction, mode));
  }
  const double scattered = model.Scattered(direction);
  outcomes[kScattered] = unhidden * model.WithOutliers(scattered);
  outcomes[kNothing] =
      1.0 - unhidden + unhidden * model.WithOutliers(model.Missed(direction) - scattered);
  double sum = 0.0;
  for (const auto& [outcome, probability] : outcomes) sum += probability;
  EXPECT_NEAR(sum, 1.0, 1e-9);
  return outcomes;
}

// Sum over the joint distribution of p(h, o) log(p(h, o) / p(h) p(o)).
double Enumerated(const std::vector<OrientationHypothesis>& belief,
                  const std::vector<std::map<int, double>>& given) {
  std::map<int, double> marginal;
  for (size_t h = 0; h < belief.size(); ++h) {
    for (const auto& [outcome, p] : given[h]) marginal[outcome] += belief[h].probability * p;
  }
  double information = 0.0;
  for (size_t h = 0; h < belief.size(); ++h) {
    for (const auto& [outcome, p] : given[h]) {
      if (p > 0.0) information += belief[h].probability * p * std::log(p / marginal[outcome]);
    }
  }
  return information;
}

// The mean, over worlds drawn at random, of by how much what was seen makes the truth likelier.
double Simulated(const std::vector<OrientationHypothesis>& belief,
                 const std::vector<std::map<int, double>>& given,
                 int count,
                 Rng& rng) {
  double sum = 0.0;
  for (int i = 0; i < count; ++i) {
    double pick = rng.Uniform();
    size_t truth = 0;
    while (truth + 1 < belief.size() && pick >= belief[truth].probability) {
      pick -= belief[truth++].probability;
    }
    pick = rng.Uniform();
    auto seen = given[truth].begin();
    while (std::next(seen) != given[truth].end() && pick >= seen->second) {
      pick -= seen->second;
      ++seen;
    }
    double all = 0.0;
    for (size_t h = 0; h < belief.size(); ++h) {
      const auto same = given[h].find(seen->first);
      if (same != given[h].end()) all += belief[h].probability * same->second;
    }
    sum += std::log(seen->second / all);
  }
  return sum / count;
}

TEST(InformationGain, IsThatOfTheEnumeratedOutcomes) {
  Rng rng(4);
  for (int trial = 0; trial < 20; ++trial) {
    SyntheticObject object;
    object.order = 2 + trial % 7;
    const ConfusionModel model = MakeConfusion(RandomTurns(object.order, 60, 10 + trial));
    const Eigen::Quaterniond q = rng.Rotation();
    const std::vector<OrientationHypothesis> belief = RandomBelief(object, q, rng);
    for (const Pose& view : ManyViews(20)) {
      for (const double unhidden : {1.0, 0.6, 0.0}) {
        std::vector<std::map<int, double>> given;
        for (const OrientationHypothesis& one : belief) {
          given.push_back(Outcomes(model, object, q, one.q_world_object, view, unhidden));
        }
        const double expected = Enumerated(belief, given);
        const double found = Information(model, belief, view, unhidden);
        EXPECT_NEAR(found, expected, 1e-12);
        EXPECT_LE(found, BeliefEntropy(belief) + 1e-12);
        EXPECT_GE(found, 0.0);
      }
    }
  }
}

TEST(InformationGain, IsTheMeanOfSimulatedLooks) {
  SyntheticObject object;
  const ConfusionModel model = MakeConfusion(RandomTurns(4, 100, 2));
  Rng rng(8);
  const Eigen::Quaterniond q = rng.Rotation();
  const std::vector<OrientationHypothesis> belief = RandomBelief(object, q, rng);
  for (const Pose& view : ManyViews(5)) {
    std::vector<std::map<int, double>> given;
    for (const OrientationHypothesis& one : belief) {
      given.push_back(Outcomes(model, object, q, one.q_world_object, view, 0.8));
    }
    EXPECT_NEAR(
        Information(model, belief, view, 0.8), Simulated(belief, given, 100'000, rng), 0.01);
  }
}

TEST(InformationGain, IsHighWhereTheFeatureTellsHypothesesApart) {
  SyntheticObject object;
  object.order = 2;
  object.error = 0.0;
  const ConfusionModel model = MakeConfusion(object.Measure(391, 100, 1));
  const std::vector<OrientationHypothesis> belief = {{object.Turn(0), 0.5}, {object.Turn(1), 0.5}};
  const Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  // From +x the first shows the feature, the second would be taken for either: three of four looks
  // that show the first speak for it.
  const double side = Information(model, belief, LookAt(Eigen::Vector3d(0.7, 0.1, 0.1), origin));
  const double exact = std::log(2.0) - 0.5 * (1.5 * std::log(1.5) - 0.5 * std::log(0.5));
  EXPECT_NEAR(side, exact, 0.03);
  // From above neither shows it.
  const double top = Information(model, belief, LookAt(Eigen::Vector3d(0.0, 0.01, 0.7), origin));
  EXPECT_LT(top, 0.01);
}

TEST(InformationGain, OrientationsEqualBySymmetryAreOneOutcome) {
  // Turns by 90 degrees are reported; those by 180 are the object's own symmetry.
  SyntheticObject object;
  ContingencyTable table;
  for (int i = 0; i < 50; ++i) {
    DirectionTrials& direction = table.directions.emplace_back();
    SyntheticObject::Count(object.Turn(0), &direction, 30 + i);
    SyntheticObject::Count(object.Turn(1), &direction, 40);
    SyntheticObject::Count(object.Turn(2), &direction, 30);
    SyntheticObject::Count(object.Turn(3), &direction, 15);
  }
  const SymmetryGroup symmetry = SymmetryGroup::Cyclic(2, Eigen::Vector3d::UnitZ());
  const ConfusionModel model = MakeConfusion(table, symmetry);
  ASSERT_EQ(model.num_modes(), 2);
  Rng rng(3);
  const Eigen::Quaterniond q = rng.Rotation();
  const std::vector<OrientationHypothesis> belief = {{q, 0.6}, {q * object.Turn(3), 0.4}};
  for (const Pose& view : ManyViews(20)) {
    std::vector<std::map<int, double>> given;
    for (const OrientationHypothesis& one : belief) {
      given.push_back(Outcomes(model, object, q, one.q_world_object, view, 1.0));
    }
    EXPECT_EQ(given[0].size(), 4U);
    EXPECT_NEAR(Information(model, belief, view), Enumerated(belief, given), 1e-12);
  }
}

TEST(InformationGain, HypothesesThatLookTheSameEverywhereCannotBeToldApart) {
  // A solid of revolution whose ends are confused, as often from everywhere.
  ContingencyTable table;
  const Eigen::Quaterniond flip = ExpSo3(std::numbers::pi * Eigen::Vector3d::UnitX());
  for (int i = 0; i < 50; ++i) {
    DirectionTrials& direction = table.directions.emplace_back();
    SyntheticObject::Count(Eigen::Quaterniond::Identity(), &direction, 50);
    SyntheticObject::Count(flip, &direction, 50);
  }
  const ConfusionModel model =
      MakeConfusion(table, SymmetryGroup::Continuous(Eigen::Vector3d::UnitZ(), false));
  ASSERT_EQ(model.num_modes(), 2);
  const Eigen::Quaterniond q = Rng(2).Rotation();
  const Eigen::Quaterniond twist = ExpSo3(1.234 * Eigen::Vector3d::UnitZ());
  const std::vector<OrientationHypothesis> belief = {{q, 0.5}, {q * flip * twist, 0.5}};
  for (const Pose& view : ManyViews(10)) EXPECT_NEAR(Information(model, belief, view), 0.0, 1e-12);
}

TEST(InformationGainView, KnowsNoModelsAndGoesOn) {
  const std::vector<Pose> candidates = ManyViews(100);
  const std::vector<Pose> visited = {candidates[3], candidates[60]};
  const std::vector<PlannedObject> objects(2);
  const PlanningState state{candidates, visited, objects, Eigen::Vector3d::Zero()};
  const ViewGains gains = InformationGainView().gains(state);
  const std::vector<double> angles = AnglesToNearestVisited(state);
  const auto farthest = std::max_element(angles.begin(), angles.end()) - angles.begin();
  const auto best = std::max_element(gains.total.begin(), gains.total.end()) - gains.total.begin();
  EXPECT_EQ(best, farthest);
  EXPECT_NEAR(gains.total[0], 2.0 * AccuracyGain(2, angles[0]), 1e-12);
  PlanningState empty = state;
  empty.objects = {};
  EXPECT_EQ(InformationGainView().gains(empty).total.size(), 100U);
}

TEST(InformationGainView, WithNothingLeftToTellApartViewsSpread) {
  const ConfusionModel model = MakeConfusion(RandomTurns(4, 100, 2));
  const std::vector<OrientationHypothesis> belief = {{Rng(1).Rotation(), 1.0}};
  PlannedObject object;
  object.confusion = &model;
  object.belief = belief;
  const std::vector<Pose> candidates = ManyViews(100);
  const std::vector<Pose> visited = {candidates[50]};
  const PlanningState state{candidates, visited, std::span(&object, 1), Eigen::Vector3d::Zero()};
  const ViewGains gains = InformationGainView().gains(state);
  const std::vector<double> angles = AnglesToNearestVisited(state);
  for (size_t i = 0; i < candidates.size(); ++i) {
    const double detected =
        InformationGain(model, belief).From(-candidates[i].linear().col(2), 1.0).detected;
    EXPECT_NEAR(gains.total[i], 0.1 * detected * AccuracyGain(1, angles[i]), 1e-12);
  }
  EXPECT_NEAR(gains.total[50], 0.0, 1e-12);
  EXPECT_LT(*std::max_element(gains.total.begin(), gains.total.end()), 0.11);
}

}  // namespace
}  // namespace vantage
