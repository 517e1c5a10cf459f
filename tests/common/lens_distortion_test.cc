#include "common/lens_distortion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "common/rng.h"

namespace vantage {
namespace {

TEST(LensDistortion, UndistortIsTheInverse) {
  const LensDistortion lens{.k1 = -0.25, .k2 = 0.08, .p1 = 0.002, .p2 = -0.003, .k3 = -0.01};
  Rng rng(3);
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector2d ideal(rng.Uniform(-0.8, 0.8), rng.Uniform(-0.6, 0.6));
    const auto undistorted = lens.Undistort(lens.Distort(ideal));
    ASSERT_TRUE(undistorted.has_value()) << ideal.transpose();
    EXPECT_LT((*undistorted - ideal).norm(), 1e-9);
  }
  EXPECT_EQ(LensDistortion{}.Undistort({0.3, -0.2}), Eigen::Vector2d(0.3, -0.2));
}

TEST(LensDistortion, WhereTheLensShowsNothingIsNoRay) {
  // x (1 - 0.5 x^2) is 0.544 at most.
  const LensDistortion barrel{.k1 = -0.5};
  EXPECT_TRUE(barrel.Undistort({0.54, 0.0}).has_value());
  EXPECT_FALSE(barrel.Undistort({0.55, 0.0}).has_value());
  EXPECT_FALSE(barrel.Undistort({50.0, 0.0}).has_value());
  for (const double k : {100.0, -100.0, 1e300, std::numeric_limits<double>::infinity()}) {
    const auto ray = LensDistortion{k, -k, k, -k, k}.Undistort({0.3, 0.2});
    EXPECT_TRUE(!ray.has_value() || ray->allFinite());
  }
}

}  // namespace
}  // namespace vantage
