#include "planner/confusion_heuristic.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "fusion/confusion/viewing_direction.h"
#include "tests/planner/planner_scenes.h"

namespace vantage {
namespace {

// The paper's words on orientations, with no use of how viewing directions turn: the truth q_GT,
// every detection of it, and how often each of the other truths would have given the same one.
double FalseReportsFrom(const ConfusionModel& model, int direction, double roll) {
  const DirectionGrid& grid = model.directions();
  const Eigen::Quaterniond truth = OrientationSeenFrom(grid.Center(direction), roll);
  double sum = model.Missed(direction);
  for (const ConfusionModel::Share& share : model.SharesFrom(direction)) {
    const Eigen::Quaterniond detected = truth * model.Difference(share.mode);
    const Eigen::Quaterniond cell =
        OrientationSeenFrom(grid.Center(model.DirectionOf(detected)), roll);
    double ambiguity = 0.0;
    for (int mode = 1; mode < model.num_modes(); ++mode) {
      const Eigen::Quaterniond other_truth = cell * model.Difference(mode).conjugate();
      ambiguity += model.ShareFrom(model.DirectionOf(other_truth), mode);
    }
    sum += share.share * ambiguity;
  }
  return sum;
}

TEST(ConfusionHeuristic, CountsFalseReportsAsThePaperSays) {
  const ConfusionModel model = MakeConfusion(RandomTurns(5, 150, 3));
  ASSERT_EQ(model.num_modes(), 5);
  const ConfusionHeuristic heuristic(model);
  Rng rng(1);
  for (int direction = 0; direction < model.num_directions(); ++direction) {
    const double roll = rng.Uniform(0.0, 2.0 * std::numbers::pi);
    EXPECT_NEAR(heuristic.FalseReports(direction), FalseReportsFrom(model, direction, roll), 1e-12);
  }
}

TEST(ConfusionHeuristic, OrderIsFromTheLeastAmbiguousOn) {
  const ConfusionModel model = MakeConfusion(RandomTurns(4, 391, 5));
  const ConfusionHeuristic heuristic(model);
  const std::span<const int> order = heuristic.Order();
  EXPECT_EQ(std::set<int>(order.begin(), order.end()).size(), 391U);
  for (size_t i = 1; i < order.size(); ++i) {
    const double before = heuristic.FalseReports(order[i - 1]);
    const double here = heuristic.FalseReports(order[i]);
    EXPECT_TRUE(before < here || (before == here && order[i - 1] < order[i]));
  }
  EXPECT_EQ(heuristic.MostFalseReports(), heuristic.FalseReports(order.back()));
  std::vector<bool> visited(391, false);
  for (const int direction : order) {
    EXPECT_EQ(heuristic.Next(visited), direction);
    visited[static_cast<size_t>(direction)] = true;
  }
  EXPECT_EQ(heuristic.Next(visited), -1);
}

// The feature can be seen from all sides, but not from above.
TEST(ConfusionHeuristic, PrefersWhereNothingIsConfused) {
  const SyntheticObject object;
  const DirectionGrid grid(391);
  const auto is_confused = [&](int i) { return grid.Center(i).z() > 0.3; };
  ContingencyTable table;
  for (int i = 0; i < 391; ++i) {
    DirectionTrials& direction = table.directions.emplace_back();
    for (int turn = 0; turn < (is_confused(i) ? 4 : 1); ++turn) {
      SyntheticObject::Count(object.Turn(turn), &direction, 50);
    }
  }
  const ConfusionHeuristic heuristic(MakeConfusion(table));
  for (int i = 0; i < 391; ++i) {
    EXPECT_NEAR(heuristic.FalseReports(i), is_confused(i) ? 0.75 : 0.0, 1e-9) << i;
  }
}

// False reports count wherever they are made: what is seen right from +x is still often reported
// when another turn is the true one, so that the paper's order prefers the other side.
TEST(ConfusionHeuristic, MindsReportsOfOtherTruths) {
  SyntheticObject object;
  object.error = 0.0;
  const ConfusionModel model = MakeConfusion(object.Measure(391, 100, 1));
  const ConfusionHeuristic heuristic(model);
  const auto from = [&](double x) {
    return heuristic.FalseReports(model.directions().CellOf(Eigen::Vector3d(x, 0.0, 0.0)));
  };
  EXPECT_NEAR(from(1.0), 0.75, 0.1);
  EXPECT_NEAR(from(-1.0), 0.5625, 0.1);
}

TEST(ConfusionHeuristic, WhereNothingIsDetectedIsNoGoodView) {
  SyntheticObject object;
  object.error = 0.0;
  ContingencyTable table = object.Measure(100, 100, 1);
  table.directions[42] = {100, 100, {}};
  const ConfusionHeuristic heuristic(MakeConfusion(table));
  EXPECT_EQ(heuristic.FalseReports(42), 1.0);
  EXPECT_EQ(heuristic.Order().back(), 42);
}

class HeuristicView : public testing::Test {
 protected:
  HeuristicView() {
    object_.error = 0.0;
    planned_.model_id = "square";
    planned_.T_world_object.linear() = Rng(7).Rotation().toRotationMatrix();
  }
  [[nodiscard]] PlanningState State() const {
    return {candidates_, visited_, std::span(&planned_, 1), Eigen::Vector3d::Zero()};
  }

  SyntheticObject object_;
  ConfusionModel model_ = MakeConfusion(object_.Measure(391, 100, 1));
  ViewCriterion criterion_ = ConfusionHeuristicView({{"square", &model_}});
  std::vector<Pose> candidates_ = ManyViews(300);
  std::vector<Pose> visited_;
  PlannedObject planned_;
};

TEST_F(HeuristicView, GainIsThatOfTheDirectionTheTopHypothesisIsSeenFrom) {
  const ConfusionHeuristic heuristic(model_);
  const std::vector<OrientationHypothesis> belief = {{Rng(9).Rotation(), 0.7},
                                                     {Rng(10).Rotation(), 0.3}};
  for (const bool has_belief : {false, true}) {
    if (has_belief) planned_.belief = belief;
    const Eigen::Matrix3d R_world_object =
        has_belief ? belief[0].q_world_object.toRotationMatrix() : planned_.T_world_object.linear();
    const ViewGains gains = criterion_.gains(State());
    ASSERT_EQ(gains.total.size(), candidates_.size());
    for (size_t i = 0; i < candidates_.size(); ++i) {
      const Eigen::Vector3d v = -R_world_object.transpose() * candidates_[i].linear().col(2);
      const double expected =
          heuristic.MostFalseReports() - heuristic.FalseReports(model_.directions().CellOf(v));
      EXPECT_NEAR(gains.total[i], expected, 1e-12);
    }
  }
}

TEST_F(HeuristicView, ADirectionSeenBeforeBringsNothing) {
  const ViewGains before = criterion_.gains(State());
  const auto best = std::max_element(before.total.begin(), before.total.end());
  const auto index = static_cast<size_t>(best - before.total.begin());
  EXPECT_GT(*best, 0.3);
  visited_ = {candidates_[index]};
  EXPECT_EQ(criterion_.gains(State()).total[index], 0.0);
}

TEST_F(HeuristicView, ObjectsAddUpAsFarAsTheyAreNotHidden) {
  PlannedObject unknown;
  unknown.model_id = "other";
  const std::vector<PlannedObject> objects = {planned_, unknown};
  std::vector<Visibility> visibility(2 * candidates_.size());
  visibility[0] = {0.0, 1};
  visibility[2] = {0.5, 1};
  PlanningState state = State();
  state.objects = objects;
  const ViewGains all = criterion_.gains(state);
  state.visibility = visibility;
  const ViewGains hidden = criterion_.gains(state);
  EXPECT_EQ(hidden.by_object[0], 0.0);
  EXPECT_NEAR(hidden.by_object[2], 0.5 * all.by_object[2], 1e-12);
  for (size_t i = 0; i < candidates_.size(); ++i) {
    EXPECT_NEAR(all.total[i], all.by_object[2 * i] + all.by_object[2 * i + 1], 1e-12);
    EXPECT_GT(all.by_object[2 * i + 1], 0.0);  // Known or not, a look is worth something.
  }
}

}  // namespace
}  // namespace vantage
