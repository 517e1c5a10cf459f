#include "planner/next_best_view.h"

#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

#include "planner/view_candidates.h"

namespace vantage {
namespace {

const Eigen::Vector3d kTarget(0.1, -0.2, 0.05);

ViewCandidateParameters Cap() {
  ViewCandidateParameters parameters;
  parameters.target = kTarget;
  return parameters;
}

double AngleFromTarget(const Pose& a, const Pose& b) {
  const Eigen::Vector3d to_a = (a.translation() - kTarget).normalized();
  const Eigen::Vector3d to_b = (b.translation() - kTarget).normalized();
  return std::acos(std::clamp(to_a.dot(to_b), -1.0, 1.0));
}

TEST(ViewCandidates, LookAtTheTargetFromTheRadius) {
  const std::vector<Pose> candidates = MakeViewCandidates(Cap());
  ASSERT_EQ(candidates.size(), 36U);
  for (const Pose& T_world_camera : candidates) {
    const Eigen::Vector3d target_in_camera = T_world_camera.inverse() * kTarget;
    EXPECT_LT((target_in_camera - Eigen::Vector3d(0.0, 0.0, 0.75)).norm(), 1e-12);
    EXPECT_LT(T_world_camera.linear()(2, 1), 0.0);  // Image down points down.
    const double elevation = std::asin((T_world_camera.translation() - kTarget).z() / 0.75);
    EXPECT_GE(elevation, 30.0 * kDegree - 1e-9);
    EXPECT_LE(elevation, 70.0 * kDegree + 1e-9);
  }
}

TEST(ViewCandidates, ThePoleIsOneView) {
  ViewCandidateParameters parameters = Cap();
  parameters.highest_elevation = 90.0 * kDegree;
  EXPECT_EQ(MakeViewCandidates(parameters).size(), 25U);
  parameters.num_elevations = 1;
  EXPECT_EQ(MakeViewCandidates(parameters).size(), 12U);
}

TEST(ViewCandidates, ParametersAreChecked) {
  EXPECT_TRUE(Cap().Validate().ok());
  ViewCandidateParameters parameters = Cap();
  parameters.lowest_elevation = 80.0 * kDegree;
  EXPECT_FALSE(parameters.Validate().ok());
  parameters = Cap();
  parameters.radius = -1.0;
  EXPECT_FALSE(parameters.Validate().ok());
  parameters = Cap();
  parameters.num_azimuths = 0;
  EXPECT_FALSE(parameters.Validate().ok());
}

TEST(FarthestView, GainIsTheAngleToTheNearestVisitedView) {
  const std::vector<Pose> candidates = MakeViewCandidates(Cap());
  const std::vector<Pose> visited = {candidates[3], candidates[20]};
  const std::vector<double> gains = FarthestView().gains({candidates, visited, {}, kTarget});
  ASSERT_EQ(gains.size(), candidates.size());
  for (size_t i = 0; i < gains.size(); ++i) {
    const double expected = std::min(AngleFromTarget(candidates[i], visited[0]),
                                     AngleFromTarget(candidates[i], visited[1]));
    EXPECT_NEAR(gains[i], expected, 1e-7);
  }
  EXPECT_NEAR(gains[3], 0.0, 1e-12);
}

TEST(NextBestView, NeverVisitsTwiceAndVisitsAll) {
  const std::vector<Pose> candidates = MakeViewCandidates(Cap());
  std::vector<CandidateStatus> status(candidates.size());
  std::vector<Pose> visited = {LookAt(Eigen::Vector3d(0.1, -0.9, 0.4), kTarget)};
  std::set<int> chosen;
  double last_gain = 10.0;
  while (true) {
    const NextView view =
        SelectNextView({candidates, visited, {}, kTarget}, FarthestView(), status, visited.back());
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
  const NextView view =
      SelectNextView({candidates, {}, {}, kTarget}, FarthestView(), status, candidates.front());
  EXPECT_EQ(view.selected, 17);
  EXPECT_EQ(view.candidates[4].reason, "joint 3 at its limit");
  EXPECT_FALSE(view.candidates[4].reachable);
  EXPECT_TRUE(view.candidates[17].reachable);
  EXPECT_TRUE(view.candidates[5].reachable);
  EXPECT_EQ(view.candidates[5].reason, "visited");
}

TEST(NextBestView, OfEqualGainsTheNearestIsTaken) {
  const std::vector<Pose> candidates = MakeViewCandidates(Cap());
  const ViewCriterion indifferent{"none", [](const PlanningState& state) {
                                    return std::vector<double>(state.candidates.size(), 1.0);
                                  }};
  const std::vector<CandidateStatus> status(candidates.size());
  const NextView view =
      SelectNextView({candidates, {}, {}, kTarget}, indifferent, status, candidates[29]);
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
