#include "planner/next_best_view.h"

#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

#include "planner/farthest_view.h"
#include "planner/view_candidates.h"

namespace vantage {
namespace {

const Eigen::Vector3d kTarget(0.1, -0.2, 0.05);

ViewCandidateParameters Cap() {
  ViewCandidateParameters parameters;
  parameters.target = kTarget;
  return parameters;
}

TEST(NextBestView, NeverVisitsTwiceAndVisitsAll) {
  const std::vector<Pose> candidates = MakeViewCandidates(Cap());
  std::vector<CandidateStatus> status(candidates.size());
  std::vector<Pose> visited = {LookAt(Eigen::Vector3d(0.1, -0.9, 0.4), kTarget)};
  std::set<int> chosen;
  double last_gain = 10.0;
  while (true) {
    const NextView view = SelectNextView({candidates, visited, {}, kTarget},
                                         FarthestView(),
                                         {.status = status, .T_world_camera = visited.back()});
    EXPECT_EQ(view.candidates.size(), candidates.size());
    EXPECT_FALSE(view.reason.empty());
    if (view.selected < 0) break;
    EXPECT_TRUE(chosen.insert(view.selected).second) << view.selected;
    const auto selected = static_cast<size_t>(view.selected);
    EXPECT_LE(view.candidates[selected].gain, last_gain + 1e-9);
    last_gain = view.candidates[selected].gain;
    status[selected].visited = true;
    visited.push_back(candidates[selected]);
  }
  EXPECT_EQ(chosen.size(), candidates.size());
}

TEST(NextBestView, LeavesOutWhatIsExcludedAndTellsWhy) {
  const std::vector<Pose> candidates = MakeViewCandidates(Cap());
  std::vector<CandidateStatus> status(candidates.size(), {false, "joint 3 at its limit"});
  status[17].refusal.clear();
  status[5] = {true, ""};
  const NextView view = SelectNextView({candidates, {}, {}, kTarget},
                                       FarthestView(),
                                       {.status = status, .T_world_camera = candidates.front()});
  EXPECT_EQ(view.selected, 17);
  EXPECT_EQ(view.candidates[4].reason, "joint 3 at its limit");
  EXPECT_FALSE(view.candidates[4].reachable);
  EXPECT_TRUE(view.candidates[17].reachable);
  EXPECT_TRUE(view.candidates[5].reachable);
  EXPECT_EQ(view.candidates[5].reason, "visited");
}

TEST(NextBestView, OfEqualGainsTheNearestIsTaken) {
  const std::vector<Pose> candidates = MakeViewCandidates(Cap());
  const ViewCriterion indifferent{
      "none", "", [](const PlanningState& state) {
        return ViewGains{std::vector<double>(state.candidates.size(), 1.0), {}};
      }};
  const std::vector<CandidateStatus> status(candidates.size());
  const NextView view = SelectNextView({candidates, {}, {}, kTarget},
                                       indifferent,
                                       {.status = status, .T_world_camera = candidates[29]});
  EXPECT_EQ(view.selected, 29);
}

// Gains in nat, of two objects.
ViewCriterion Fixed(const std::vector<double>& by_object) {
  return {"fixed", kNat, [by_object](const PlanningState&) {
            ViewGains gains{{}, by_object};
            for (size_t i = 0; i < by_object.size(); i += 2) {
              gains.total.push_back(by_object[i] + by_object[i + 1]);
            }
            return gains;
          }};
}

class TwoObjects : public testing::Test {
 protected:
  TwoObjects() {
    objects_[0].model_id = "mug";
    objects_[1].model_id = "filter";
    objects_[1].instance_id = 1;
    for (const double x : {0.1, 0.2, 0.9}) {
      candidates_.push_back(LookAt(Eigen::Vector3d(x, 0.0, 0.7), kTarget));
    }
    status_.resize(3);
    camera_.translation() = Eigen::Vector3d(0.0, 0.0, 0.7);
  }
  [[nodiscard]] PlanningState State() const { return {candidates_, {}, objects_, kTarget}; }
  [[nodiscard]] ViewChoice Choice(double travel_weight = 0.0) const {
    return {.status = status_, .T_world_camera = camera_, .travel_weight = travel_weight};
  }

  std::vector<Pose> candidates_;
  std::vector<PlannedObject> objects_{2};
  std::vector<CandidateStatus> status_;
  Pose camera_ = Pose::Identity();
};

TEST_F(TwoObjects, TheReasonTellsWhatEachBringsAndTheRunnerUp) {
  const NextView view = SelectNextView(State(), Fixed({0.2, 0.2, 0.03, 0.61, 0.1, 0.5}), Choice());
  EXPECT_EQ(view.selected, 1);
  EXPECT_EQ(view.reason,
            "view 1: expected gain 0.64 nat (filter #1 0.61, mug #0 0.03) by criterion \"fixed\", "
            "0.20 m away; runner-up 2 with 0.60, 0.90 m away");
  EXPECT_EQ(view.information, 0.0);  // About objects with a confusion model: there are none.
}

TEST_F(TwoObjects, TheWayIsWeighedAgainstTheGain) {
  const ViewCriterion criterion = Fixed({0.3, 0.0, 0.4, 0.0, 0.6, 0.0});
  EXPECT_EQ(SelectNextView(State(), criterion, Choice(0.0)).selected, 2);
  EXPECT_EQ(SelectNextView(State(), criterion, Choice(0.5)).selected, 1);
  EXPECT_EQ(SelectNextView(State(), criterion, Choice(2.0)).selected, 0);
  ViewCriterion in_radians = criterion;
  in_radians.unit = "rad";
  EXPECT_EQ(SelectNextView(State(), in_radians, Choice(2.0)).selected, 2);
  EXPECT_FALSE(SelectNextView(State(), in_radians, Choice(2.0)).information.has_value());
}

TEST_F(TwoObjects, WhereAllIsHiddenThereIsNothingToLookFor) {
  const std::vector<Visibility> visibility = {
      {0.1, 1}, {0.0, Visibility::kImage}, {0.9, 1}, {0.0, 0}, {0.0, Visibility::kTable}, {0.2, 0}};
  PlanningState state = State();
  state.visibility = visibility;
  const NextView view = SelectNextView(state, Fixed({9, 9, 0, 1, 9, 9}), Choice());
  EXPECT_EQ(view.selected, 1);
  EXPECT_EQ(view.candidates[0].reason, "occluded by filter #1");
  EXPECT_EQ(view.candidates[0].rejection, JudgedView::Rejection::kHidden);
  EXPECT_TRUE(view.candidates[0].reachable);
  EXPECT_EQ(view.candidates[2].reason, "occluded by the table");
}

TEST_F(TwoObjects, WhenNoneIsLeftItTellsHowManyForWhichReason) {
  const std::vector<std::string> out_of_reach = {"", "in the keep-out volume \"wall\"", ""};
  status_[0].visited = true;
  status_[2].refusal = "joint 3 at its limit";
  ViewChoice choice = Choice();
  choice.out_of_reach = out_of_reach;
  const NextView view = SelectNextView(State(), Fixed({0, 0, 0, 0, 0, 0}), choice);
  EXPECT_EQ(view.selected, -1);
  EXPECT_EQ(view.reason,
            "none of the 3 views is left: 1 visited, 1 out of reach or in keep-out volumes, 1 "
            "refused by the robot");
  EXPECT_FALSE(view.candidates[1].reachable);
  EXPECT_EQ(view.candidates[1].reason, out_of_reach[1]);
}

TEST(NextBestView, NearestCandidateIsTheOneInTheViewsDirection) {
  const std::vector<Pose> candidates = MakeViewCandidates(Cap());
  for (size_t i = 0; i < candidates.size(); ++i) {
    Pose near = candidates[i];
    near.translation() = kTarget + 1.3 * (near.translation() - kTarget);
    near.translation() += Eigen::Vector3d(0.01, -0.02, 0.01);
    EXPECT_EQ(NearestCandidate(candidates, near, kTarget), static_cast<int>(i));
  }
  EXPECT_EQ(NearestCandidate({}, Pose::Identity(), kTarget), -1);
}

}  // namespace
}  // namespace vantage
