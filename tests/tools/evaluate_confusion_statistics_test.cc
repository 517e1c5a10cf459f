#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "common/rng.h"
#include "tools/evaluate/confusion_statistics.h"
#include "tools/evaluate/confusion_strategies.h"

namespace vantage {
namespace {

constexpr double kEnough = 0.95;

std::vector<ConfusionStep> Steps(const std::vector<double>& right_mass) {
  std::vector<ConfusionStep> steps;
  for (const double mass : right_mass) {
    ConfusionStep step;
    step.right_mass = mass;
    step.best_mass = std::max(mass, 1.0 - mass);
    step.is_best_right = mass >= 0.5;
    steps.push_back(step);
  }
  return steps;
}

TEST(ViewsToHold, CountsFromTheLastTimeThatItWasNotHeld) {
  EXPECT_EQ(ViewsToHold(Steps({0.99, 0.99, 0.99}), kEnough), 1);
  EXPECT_EQ(ViewsToHold(Steps({0.5, 0.96, 0.2, 0.97, 0.95}), kEnough), 4);
  EXPECT_EQ(ViewsToReach(Steps({0.5, 0.96, 0.2, 0.97, 0.95}), kEnough), 2);
  EXPECT_EQ(ViewsToHold(Steps({0.99, 0.99, 0.94}), kEnough), 4);
  EXPECT_EQ(ViewsToReach(Steps({0.1, 0.2}), kEnough), 3);
  EXPECT_EQ(ViewsToHold({}, kEnough), 1);
}

TEST(RatioOfMeans, HoldsTheTrueRatio) {
  Rng rng(3);
  std::vector<double> a;
  std::vector<double> b;
  std::vector<int> groups;
  for (int i = 0; i < 400; ++i) {
    a.push_back(rng.Uniform(1.0, 3.0));
    b.push_back(rng.Uniform(2.0, 6.0));
    groups.push_back(i % 4);
  }
  BootstrapParameters parameters;
  parameters.groups = groups;
  const Interval ratio = RatioOfMeans(a, b, parameters, rng);
  EXPECT_LT(ratio.low, 0.5);
  EXPECT_GT(ratio.high, 0.5);
  EXPECT_LT(ratio.high - ratio.low, 0.1);
  const Interval same = RatioOfMeans(a, a, parameters, rng);
  EXPECT_NEAR(same.low, 1.0, 1e-12);
  EXPECT_NEAR(same.high, 1.0, 1e-12);
}

// Two strategies that matter: ours holds after so many views, all others after so many.
ConfusionResults Summarized(int num_objects, int ours, int others) {
  ConfusionResults results;
  results.seed = 1;
  results.views = 10;
  results.enough = kEnough;
  for (const ConfusionStrategy& strategy : ConfusionStrategies(10)) {
    results.strategies.push_back(strategy.label);
    results.strategy_ids.push_back(strategy.id);
  }
  std::vector<std::vector<StrategyRuns>> runs;
  std::vector<ObjectViewsNeeded> objects;
  for (int object = 0; object < num_objects; ++object) {
    runs.emplace_back();
    objects.push_back({"object", "none", {}, {}});
    for (const std::string& id : results.strategy_ids) {
      std::vector<double> mass(10, 1.0);
      const int views = id == kInformationGainId ? ours : others;
      for (int i = 0; i + 1 < views; ++i) mass[static_cast<size_t>(i)] = 0.3;
      runs.back().push_back(StrategyRuns(5, Steps(mass)));
    }
  }
  SummarizeConfusionViews(runs, objects, &results);
  return results;
}

TEST(SummarizeConfusionViews, TellsWhetherTheBarsAreMet) {
  const ConfusionResults good = Summarized(10, 2, 4);
  EXPECT_TRUE(MissedBars(good).empty());
  EXPECT_NEAR(good.ratio_to_random.value, 0.5, 1e-12);
  EXPECT_NEAR(good.all_objects[0].less_heuristic.value, -2.0, 1e-12);
  EXPECT_EQ(good.objects.size(), 10U);
  EXPECT_EQ(good.still_open[0], 1.0);
  EXPECT_EQ(good.still_open[2], 0.0);

  EXPECT_EQ(MissedBars(Summarized(9, 2, 4)).size(), 1U);
  const std::vector<std::string> missed = MissedBars(Summarized(10, 4, 4));
  ASSERT_EQ(missed.size(), 2U);
  EXPECT_NE(missed[0].find("random"), std::string::npos);
  EXPECT_NE(missed[1].find("heuristic"), std::string::npos);
}

TEST(SummarizeConfusionViews, CountsWhatNeverHoldsAsOneMoreView) {
  const ConfusionResults results = Summarized(1, 11, 11);
  EXPECT_EQ(results.all_objects[0].mean.value, 11.0);
  EXPECT_EQ(results.all_objects[0].never_share, 1.0);
  EXPECT_EQ(results.all_objects[0].final_right, 0.0);
}

TEST(SummarizeConfusionViews, CalibrationAddsUp) {
  const ConfusionResults results = Summarized(2, 3, 3);
  int64_t steps = 0;
  for (const CalibrationBin& bin : results.calibration) {
    steps += bin.count;
    if (bin.count > 0) {
      EXPECT_GE(bin.mean_mass, bin.low);
      EXPECT_LE(bin.mean_mass, bin.high);
    }
  }
  EXPECT_EQ(steps, 2 * 5 * 5 * 10);
  EXPECT_EQ(results.calibration.back().right, 1.0);
}

TEST(ChooseView, TakesTheLargestGainAndOfEqualOnesTheNearest) {
  std::vector<Pose> candidates(4, Pose::Identity());
  for (int i = 0; i < 4; ++i) candidates[static_cast<size_t>(i)].translation().x() = i;
  std::vector<double> gains = {1.0, 2.0, 2.0, 0.0};
  const ViewCriterion criterion{"fixed", "", [&](const PlanningState&) {
                                  return ViewGains{gains, {}};
                                }};
  PlanningState state;
  state.candidates = candidates;
  std::vector<bool> taken(4, false);
  EXPECT_EQ(ChooseView(criterion, state, taken), 1);
  state.visited = {&candidates[3], 1};
  EXPECT_EQ(ChooseView(criterion, state, taken), 2);
  taken[2] = true;
  EXPECT_EQ(ChooseView(criterion, state, taken), 1);
  taken.assign(4, true);
  EXPECT_EQ(ChooseView(criterion, state, taken), -1);
}

}  // namespace
}  // namespace vantage
