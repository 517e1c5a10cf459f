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
