#include "drivers/v4l2/disparity_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace vantage {
namespace {

TEST(DisparityModel, NominalValuesAgreeWithTwoPublishedFits) {
  const DisparityModel model;
  // Two independent fits to measured walls, published as 1 / (-0.0030711016 d + 3.3309495161) and
  // 0.1236 tan(d / 2842.5 + 1.1863), in m.
  for (int d = 500; d <= 1000; d += 10) {
    const double inverse = 1e3 / (-0.0030711016 * d + 3.3309495161);
    const double tangent = 123.6 * std::tan(d / 2842.5 + 1.1863);
    EXPECT_NEAR(model.DepthMm(d), inverse, 0.065 * inverse) << d;
    EXPECT_NEAR(model.DepthMm(d), tangent, 0.025 * tangent) << d;
  }
}

TEST(DisparityModel, TwoDistancesGiveItsConstants) {
  // As docs/drivers.md tells how to calibrate: 1 / z is linear in d.
  DisparityModel truth;
  truth.focal_px = 594.2;
  truth.offset = 1084.3;
  const int d1 = 640;
  const int d2 = 950;
  const auto depth = [&](int d) {
    return truth.baseline_mm * truth.focal_px * truth.steps_per_px / (truth.offset - d);
  };
  const double z1 = depth(d1);
  const double z2 = depth(d2);
  DisparityModel found;
  found.offset = (z2 * d2 - z1 * d1) / (z2 - z1);
  found.focal_px = z1 * (found.offset - d1) / (found.baseline_mm * found.steps_per_px);
  EXPECT_NEAR(found.offset, truth.offset, 1e-9);
  EXPECT_NEAR(found.focal_px, truth.focal_px, 1e-9);
}

TEST(DisparityModel, GrowsWithDisparityUpToInfinity) {
  const DisparityModel model;
  for (int d = 1; d < 1084; ++d) EXPECT_GE(model.DepthMm(d), model.DepthMm(d - 1));
  EXPECT_EQ(model.DepthMm(0), std::lround(75.0 * 580.0 * 8.0 / 1090.0));
  EXPECT_EQ(model.DepthMm(1085), 0) << "69.6 m are more than 16 bits hold";
  EXPECT_EQ(model.DepthMm(1090), 0);
  EXPECT_EQ(model.DepthMm(2047), 0);
  EXPECT_EQ(model.DepthMm(std::numeric_limits<int>::max()), 0);
}

TEST(DisparityModel, RefusesWhatIsOutOfRange) {
  EXPECT_TRUE(DisparityModel().Validate().ok());
  for (double DisparityModel::*const member : {&DisparityModel::baseline_mm,
                                               &DisparityModel::focal_px,
                                               &DisparityModel::offset,
                                               &DisparityModel::steps_per_px}) {
    for (const double bad : {0.0, -1.0, 1e9, std::nan(""), HUGE_VAL}) {
      DisparityModel model;
      model.*member = bad;
      EXPECT_FALSE(model.Validate().ok()) << bad;
    }
  }
}

TEST(DisparityTable, HasNoDistanceForTheHighestValue) {
  DisparityModel model;
  model.offset = 2000.0;
  const std::array<uint16_t, 1024> table = DisparityTable(model);
  EXPECT_EQ(table[1023], 0);
  EXPECT_GT(model.DepthMm(1023), 0);
  for (int d = 0; d < 1023; ++d) EXPECT_EQ(table[static_cast<size_t>(d)], model.DepthMm(d));
}

}  // namespace
}  // namespace vantage
