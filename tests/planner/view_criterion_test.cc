#include "planner/view_criterion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <vector>

#include "planner/circle_view.h"
#include "planner/farthest_view.h"
#include "planner/random_view.h"
#include "tests/planner/planner_scenes.h"

namespace vantage {
namespace {

const Eigen::Vector3d kTarget = Eigen::Vector3d::Zero();

double Angle(const Pose& a, const Pose& b) {
  const Eigen::Vector3d to_a = a.translation().normalized();
  const Eigen::Vector3d to_b = b.translation().normalized();
  return std::acos(std::clamp(to_a.dot(to_b), -1.0, 1.0));
}

size_t BestOf(const ViewGains& gains) {
  return static_cast<size_t>(std::max_element(gains.total.begin(), gains.total.end()) -
                             gains.total.begin());
}

TEST(FarthestView, GainIsTheAngleToTheNearestVisitedView) {
  const std::vector<Pose> candidates = ManyViews(60);
  const std::vector<Pose> visited = {candidates[3], candidates[20]};
  const ViewGains gains = FarthestView().gains({candidates, visited, {}, kTarget});
  ASSERT_EQ(gains.total.size(), candidates.size());
  for (size_t i = 0; i < candidates.size(); ++i) {
    const double expected =
        std::min(Angle(candidates[i], visited[0]), Angle(candidates[i], visited[1]));
    EXPECT_NEAR(gains.total[i], expected, 1e-7);
  }
  EXPECT_NEAR(gains.total[3], 0.0, 1e-12);
}

TEST(RandomView, IsTheSameForTheSameSeedAndAnyViewIsAsLikely) {
  const std::vector<Pose> candidates = ManyViews(10);
  const std::vector<Pose> visited(5, candidates[0]);
  const PlanningState state{candidates, visited, {}, kTarget};
  EXPECT_EQ(RandomView(3).gains(state).total, RandomView(3).gains(state).total);
  PlanningState next = state;
  next.visited = state.visited.first(4);
  EXPECT_NE(RandomView(3).gains(state).total, RandomView(3).gains(next).total);
  std::vector<int> counts(10, 0);
  for (uint64_t seed = 0; seed < 5000; ++seed) ++counts[BestOf(RandomView(seed).gains(state))];
  for (const int count : counts) EXPECT_NEAR(count, 500, 5.0 * std::sqrt(450.0));
}

TEST(CircleView, GoesRoundInEvenSteps) {
  CircleViewParameters parameters;
  parameters.step = 30.0 * kDegree;
  ViewCandidateParameters rings;
  rings.lowest_elevation = 30.0 * kDegree;
  rings.highest_elevation = 60.0 * kDegree;
  rings.num_elevations = 3;
  const std::vector<Pose> candidates = MakeViewCandidates(rings);
  std::vector<Pose> visited;
  std::set<size_t> chosen;
  for (int i = 0; i < 12; ++i) {
    const size_t best = BestOf(CircleView(parameters).gains({candidates, visited, {}, kTarget}));
    const Eigen::Vector3d from = candidates[best].translation() - kTarget;
    EXPECT_NEAR(std::asin(from.normalized().z()), 45.0 * kDegree, 1e-9);
    if (!visited.empty()) {
      const Eigen::Vector2d before = visited.back().translation().head<2>();
      const double turned =
          std::atan2(before.x() * from.y() - before.y() * from.x(), before.dot(from.head<2>()));
      EXPECT_NEAR(turned, parameters.step, 1e-9);
    }
    EXPECT_TRUE(chosen.insert(best).second);
    visited.push_back(candidates[best]);
  }
}

TEST(CircleView, ParametersAreChecked) {
  EXPECT_TRUE(CircleViewParameters().Validate().ok());
  for (const CircleViewParameters& wrong : std::vector<CircleViewParameters>{
           {2.0, 0.1}, {NAN, 0.1}, {0.5, 0.0}, {0.5, 4.0}, {0.5, NAN}}) {
    EXPECT_FALSE(wrong.Validate().ok()) << wrong.elevation << " " << wrong.step;
  }
}

TEST(AccuracyGain, FallsWithTheNumberOfViewsAndRisesWithTheAngle) {
  EXPECT_NEAR(AccuracyGain(1, std::numbers::pi), 1.5 * std::log(2.0), 1e-12);
  EXPECT_EQ(AccuracyGain(0, 1.0), AccuracyGain(1, 1.0));
  for (size_t n = 1; n < 20; ++n) {
    EXPECT_GT(AccuracyGain(n, 1.0), AccuracyGain(n + 1, 1.0));
    EXPECT_GT(AccuracyGain(n, 1.0), AccuracyGain(n, 0.9));
    EXPECT_EQ(AccuracyGain(n, 0.0), 0.0);
  }
}

}  // namespace
}  // namespace vantage
