#include "fusion/compared/mean_orientation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "common/rng.h"
#include "common/so3.h"

namespace vantage {
namespace {

// What the chordal mean minimizes: the sum of squared Frobenius distances.
double ChordalCost(const std::vector<Eigen::Quaterniond>& views, const Eigen::Quaterniond& q) {
  double cost = 0.0;
  for (const Eigen::Quaterniond& view : views) {
    cost += (view.toRotationMatrix() - q.toRotationMatrix()).squaredNorm();
  }
  return cost;
}

TEST(MeanOrientation, MinimizesTheChordalCost) {
  Rng rng(1);
  for (const double spread : {1.0 * kDegree, 20.0 * kDegree, 60.0 * kDegree}) {
    const Eigen::Quaterniond truth = rng.Rotation();
    MeanOrientation mean;
    std::vector<Eigen::Quaterniond> views;
    for (int i = 0; i < 15; ++i) {
      const Eigen::Vector3d error(rng.Normal(), rng.Normal(), rng.Normal());
      views.push_back(truth * ExpSo3(spread * error));
      // Either sign is the same orientation.
      const double sign = rng.Uniform() < 0.5 ? -1.0 : 1.0;
      ASSERT_TRUE(mean.Add({Eigen::Quaterniond(sign * views.back().coeffs()), 1e-6}).ok());
    }
    const Eigen::Quaterniond q = mean.Estimate().value();
    EXPECT_EQ(q.coeffs(), Canonical(q).coeffs());
    const double cost = ChordalCost(views, q);
    for (int i = 0; i < 300; ++i) {
      const Eigen::Quaterniond near = q * ExpSo3(rng.Uniform(1e-3, 1.0) * rng.UnitVector());
      EXPECT_GT(ChordalCost(views, near), cost);
      EXPECT_GT(ChordalCost(views, rng.Rotation()), cost);
    }
  }
}

TEST(MeanOrientation, OneAndTwoViews) {
  Rng rng(2);
  const Eigen::Quaterniond a = rng.Rotation();
  const Eigen::Vector3d turn = 0.8 * rng.UnitVector();
  MeanOrientation mean;
  EXPECT_FALSE(mean.Estimate().ok());
  ASSERT_TRUE(mean.Add({a, 0.0}).ok());
  EXPECT_LT(GeodesicAngle(mean.Estimate().value(), a), 1e-12);
  ASSERT_TRUE(mean.Add({a * ExpSo3(turn), 0.0}).ok());
  EXPECT_LT(GeodesicAngle(mean.Estimate().value(), a * ExpSo3(0.5 * turn)), 1e-12);
}

TEST(MeanOrientation, BadViewsChangeNothingNearUnitOnesCountTheSame) {
  Rng rng(3);
  MeanOrientation mean;
  const Eigen::Quaterniond a = rng.Rotation();
  const Eigen::Vector3d turn = 0.5 * rng.UnitVector();
  ASSERT_TRUE(mean.Add({Eigen::Quaterniond(1.0009 * a.coeffs()), 0.0}).ok());
  ASSERT_TRUE(mean.Add({a * ExpSo3(turn), 0.0}).ok());
  const Eigen::Quaterniond before = mean.Estimate().value();
  EXPECT_LT(GeodesicAngle(before, a * ExpSo3(0.5 * turn)), 1e-12);
  EXPECT_FALSE(mean.Add({Eigen::Quaterniond(1.1 * a.coeffs()), 0.0}).ok());
  EXPECT_FALSE(mean.Add({a, -1.0}).ok());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(mean.Add({Eigen::Quaterniond(nan, 0.0, 0.0, 0.0), 0.0}).ok());
  EXPECT_EQ(mean.Estimate().value().coeffs(), before.coeffs());
}

}  // namespace
}  // namespace vantage
