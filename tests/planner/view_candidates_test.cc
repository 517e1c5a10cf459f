#include "planner/view_candidates.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace vantage {
namespace {

const Eigen::Vector3d kTarget(0.1, -0.2, 0.05);

ViewCandidateParameters Cap() {
  ViewCandidateParameters parameters;
  parameters.target = kTarget;
  return parameters;
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

TEST(ViewCandidates, SpreadOnesAreEven) {
  ViewCandidateParameters parameters = Cap();
  parameters.count = 500;
  const std::vector<Pose> candidates = MakeViewCandidates(parameters);
  ASSERT_EQ(candidates.size(), 500U);
  // Were each the middle of a hexagon, its neighbors would be so far apart.
  const double area = 2.0 * M_PI * (std::sin(70.0 * kDegree) - std::sin(30.0 * kDegree)) / 500.0;
  const double hexagonal = std::sqrt(2.0 / std::sqrt(3.0) * area);
  for (const Pose& a : candidates) {
    const Eigen::Vector3d direction = (a.translation() - kTarget) / parameters.radius;
    EXPECT_NEAR(direction.norm(), 1.0, 1e-12);
    EXPECT_GE(std::asin(direction.z()), 30.0 * kDegree);
    EXPECT_LE(std::asin(direction.z()), 70.0 * kDegree);
    double nearest = 10.0;
    for (const Pose& b : candidates) {
      if (&a == &b) continue;
      nearest = std::min(nearest, (a.translation() - b.translation()).norm() / parameters.radius);
    }
    EXPECT_GT(nearest, 0.7 * hexagonal);
    EXPECT_LT(nearest, 1.1 * hexagonal);
  }
  parameters.count = -1;
  EXPECT_FALSE(parameters.Validate().ok());
  parameters.count = 100'000'000;
  EXPECT_FALSE(parameters.Validate().ok());
}

}  // namespace
}  // namespace vantage
