#include "common/depth_image.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace vantage {
namespace {

TEST(DepthImage, StartsWithoutMeasurements) {
  const DepthImage image(3, 2);
  ASSERT_EQ(image.depth.size(), 6U);
  for (const float value : image.depth) EXPECT_TRUE(std::isnan(value));
  EXPECT_TRUE(image.Contains(0, 0));
  EXPECT_TRUE(image.Contains(2, 1));
  for (const auto& [u, v] : {std::pair{3, 0}, {0, 2}, {-1, 0}, {0, -1}}) {
    EXPECT_FALSE(image.Contains(u, v));
  }
}

TEST(DepthImage, LiesRowByRow) {
  DepthImage image(3, 2);
  image.at(2, 1) = 4.0F;
  EXPECT_EQ(image.depth[5], 4.0F);
  EXPECT_EQ(image.Index(1, 1), 4U);
}

TEST(DepthImage, MillimetresComeBackExactly) {
  std::vector<uint16_t> millimetres(65536);
  for (size_t i = 0; i < millimetres.size(); ++i) millimetres[i] = static_cast<uint16_t>(i);
  const DepthImage image = DepthFromMillimetres(256, 256, millimetres.data());
  EXPECT_TRUE(std::isnan(image.depth[0]));
  EXPECT_FLOAT_EQ(image.depth[1234], 1.234F);
  EXPECT_EQ(DepthToMillimetres(image), millimetres);
}

TEST(DepthImage, WhatTheWireCannotTellBecomesZero) {
  DepthImage image(9, 1);
  const float infinity = std::numeric_limits<float>::infinity();
  image.depth = {
      DepthImage::kInvalid, infinity, -infinity, 0.0F, -1.0F, 65.536F, 1e30F, 0.0004F, -0.0F};
  for (const uint16_t value : DepthToMillimetres(image)) EXPECT_EQ(value, 0);
  image.depth = {65.535F, 0.001F, 0.0006F, 1.0004F, 1.0006F, 2.0F, 2.0F, 2.0F, 2.0F};
  const std::vector<uint16_t> millimetres = DepthToMillimetres(image);
  EXPECT_EQ(millimetres[0], 65535);
  EXPECT_EQ(millimetres[1], 1);
  EXPECT_EQ(millimetres[2], 1);
  EXPECT_EQ(millimetres[3], 1000);
  EXPECT_EQ(millimetres[4], 1001);
}

}  // namespace
}  // namespace vantage
