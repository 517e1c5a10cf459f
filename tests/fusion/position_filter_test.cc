#include "fusion/position_filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "common/rng.h"

namespace vantage {
namespace {

Eigen::Vector3d Noise(double sigma, Rng& rng) {
  return sigma * Eigen::Vector3d(rng.Normal(), rng.Normal(), rng.Normal());
}

TEST(PositionFilter, OneViewIsItself) {
  const Eigen::Vector3d p(0.1, -0.2, 0.3);
  const std::vector<PositionView> views = {{p, 0.5}};
  const PositionFilterParameters parameters;
  const PositionEstimate estimate = FusePositions(views, parameters);
  EXPECT_LT((estimate.p_world - p).norm(), 1e-12);
  EXPECT_NEAR(estimate.covariance(0, 0), std::pow(parameters.sigma_floor, 2), 1e-15);
}

TEST(PositionFilter, AWrongMinorityHasNoEffect) {
  Rng rng(1);
  std::vector<PositionView> views;
  for (int i = 0; i < 6; ++i) views.push_back({Noise(0.001, rng), 1.0});
  const PositionEstimate before = FusePositions(views, {});
  for (int i = 0; i < 5; ++i) views.push_back({Eigen::Vector3d(0.06 + 0.04 * i, 0.0, 0.0), 1.0});
  const PositionEstimate after = FusePositions(views, {});
  EXPECT_LT((after.p_world - before.p_world).norm(), 1e-12);
  EXPECT_EQ(after.inliers.size(), 6U);
}

TEST(PositionFilter, AnOutlierInsideTheGateMovesItLittle) {
  std::vector<PositionView> views(5, PositionView{});
  views.push_back({Eigen::Vector3d(0.025, 0.0, 0.0), 1.0});
  EXPECT_LT(FusePositions(views, {}).p_world.norm(), 0.0012);  // The mean would be at 4.2 mm.
}

// The covariance is honest: the error of the mean has the size that it tells.
TEST(PositionFilter, CovarianceIsThatOfTheMean) {
  Rng rng(2);
  PositionFilterParameters parameters;
  parameters.sigma_floor = 1e-6;
  double error = 0.0;
  double predicted = 0.0;
  for (int trial = 0; trial < 400; ++trial) {
    std::vector<PositionView> views;
    for (int i = 0; i < 20; ++i) views.push_back({Noise(0.001, rng), 1.0});
    const PositionEstimate estimate = FusePositions(views, parameters);
    error += estimate.p_world.squaredNorm();
    predicted += estimate.covariance.trace();
  }
  EXPECT_NEAR(predicted / error, 1.0, 0.2);
}

TEST(PositionFilter, ParametersAreChecked) {
  EXPECT_TRUE(PositionFilterParameters().Validate().ok());
  EXPECT_FALSE((PositionFilterParameters{.gate = 0.0}).Validate().ok());
  EXPECT_FALSE((PositionFilterParameters{.huber = NAN}).Validate().ok());
}

}  // namespace
}  // namespace vantage
