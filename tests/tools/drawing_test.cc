// Colors, lines, light and spheres of the pictures in reports.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <vector>

#include "common/rng.h"
#include "tools/support/color.h"
#include "tools/support/rgb_canvas.h"
#include "tools/support/shaded_scene.h"
#include "tools/support/sphere_renderer.h"

namespace vantage {
namespace {

// Luminance as a grey print would show it (ITU-R BT.709), 0..255.
double Grey(Rgb color) { return 0.2126 * color.r + 0.7152 * color.g + 0.0722 * color.b; }

TriangleMesh Box(double x, double y, double z) { return TableMesh({0.0, 0.0, z}, x, y, z); }

TEST(Color, MapsDarkenEvenlyAndClamp) {
  for (Rgb (*map)(double) : {&DepthColor, &DensityColor}) {
    for (int i = 0; i < 100; ++i) {
      EXPECT_GT(Grey(map(i / 100.0)), Grey(map((i + 1) / 100.0))) << i;
    }
    EXPECT_EQ(map(-3.0), map(0.0));
    EXPECT_EQ(map(7.0), map(1.0));
    EXPECT_EQ(map(std::numeric_limits<double>::quiet_NaN()), map(0.0));
  }
}

TEST(Color, HexHasTwoDigitsAChannel) { EXPECT_EQ(HexColor({0, 10, 255}), "#000aff"); }

TEST(Color, ObjectsDifferAndRepeatOnlyAfterEight) {
  for (size_t i = 0; i < 8; ++i) {
    for (size_t j = 0; j < i; ++j) EXPECT_FALSE(ObjectColor(i) == ObjectColor(j)) << i << " " << j;
    EXPECT_EQ(ObjectColor(i), ObjectColor(i + 8));
  }
}

TEST(RgbCanvas, LineCoversItsLengthTimesItsWidth) {
  RgbImage image = FilledImage(100, 60, {0, 0, 0});
  DrawLine(image, {20.0, 10.0}, {80.0, 50.0}, 4.0, {255, 255, 255});
  double covered = 0.0;
  for (int v = 0; v < 60; ++v) {
    for (int u = 0; u < 100; ++u) covered += PixelAt(image, u, v).r / 255.0;
  }
  const double length = std::hypot(60.0, 40.0);
  EXPECT_NEAR(covered, 4.0 * length + std::numbers::pi * 4.0, 6.0);  // With its round ends.
}

TEST(RgbCanvas, OutsideAndWithoutNumberNothingHappens) {
  RgbImage image = FilledImage(8, 8, {1, 2, 3});
  const RgbImage before = image;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  DrawLine(image, {nan, 1.0}, {3.0, 3.0}, 2.0, {9, 9, 9});
  DrawLine(image, {1e300, 1.0}, {1e301, 3.0}, 2.0, {9, 9, 9});
  DrawLine(image, {-50.0, -50.0}, {-40.0, -60.0}, 2.0, {9, 9, 9});
  SetPixel(image, 8, 0, {9, 9, 9});
  SetPixel(image, 0, -1, {9, 9, 9});
  BlendPixel(image, 2, 2, {9, 9, 9}, nan);
  EXPECT_EQ(image.rgb, before.rgb);
}

TEST(RgbCanvas, DownsampleIsTheMeanOfEachBlock) {
  Rng rng(3);
  RgbImage image = FilledImage(7, 5, {});
  for (uint8_t& value : image.rgb) value = static_cast<uint8_t>(rng.Below(256));
  const RgbImage small = Downsample(image, 2);
  ASSERT_EQ(small.width, 3);
  ASSERT_EQ(small.height, 2);
  const double mean = (PixelAt(image, 2, 2).g + PixelAt(image, 3, 2).g + PixelAt(image, 2, 3).g +
                       PixelAt(image, 3, 3).g) /
                      4.0;
  EXPECT_NEAR(PixelAt(small, 1, 1).g, mean, 0.51);
}

TEST(ShadedScene, ObjectThrowsItsShadowAwayFromTheLamp) {
  const TriangleMesh table = TableMesh({0.0, 0.0, 0.0}, 1.0, 1.0, 0.02);
  const TriangleMesh post = Box(0.06, 0.06, 0.15);
  ShadedScene scene;
  scene.items = {{&table, Pose::Identity(), {200, 200, 200}},
                 {&post, Pose::Identity(), {200, 30, 30}}};
  scene.light = {1.0, 0.0, 1.0};
  CameraModel camera{121, 121, 200.0, 200.0, 60.0, 60.0};
  // From above: the picture's right is the world's x.
  const Pose T_world_camera = LookAt({0.0, 0.0, 1.0}, {0.0, 0.0, 0.0}, {0.0, 1.0, 0.0});
  const RgbImage image = RenderShaded(scene, camera, T_world_camera);
  const auto grey_at = [&](double x) {
    const Eigen::Vector2d pixel =
        camera.Project(T_world_camera.inverse() * Eigen::Vector3d(x, 0.0, 0.0));
    return Grey(PixelAt(
        image, static_cast<int>(std::lround(pixel.x())), static_cast<int>(std::lround(pixel.y()))));
  };
  EXPECT_LT(grey_at(-0.10), 0.85 * grey_at(0.10));  // 0.15 m high, lamp at 45 degrees.
  EXPECT_NEAR(grey_at(-0.25), grey_at(0.10), 2.0);  // Behind the shadow's end.
}

TEST(ShadedScene, WithoutItemsThereIsASky) {
  const RgbImage image = RenderShaded({}, {32, 24, 30.0, 30.0, 15.5, 11.5}, Pose::Identity());
  EXPECT_EQ(image.rgb.size(), 32U * 24U * 3U);
  EXPECT_GT(Grey(PixelAt(image, 3, 3)), 200.0);
}

TEST(SphereRenderer, WeightShowsWhereItIsAndOnlyOnItsSide) {
  SphereView view;
  view.radius_px = 50;
  view.towards = {0.0, 0.0, 1.0};
  // Seen from z: the right of the picture is x.
  const Eigen::Vector3d direction = Eigen::Vector3d(0.5, 0.0, std::sqrt(0.75));
  const SphereSample sample{direction.cast<float>(), 2.0F};
  const RgbImage image = RenderSphereDensity(std::span(&sample, 1), view);
  ASSERT_EQ(image.width, 4 * 50 + 3 * 8);
  ASSERT_EQ(image.height, 2 * 50 + 2 * 8);
  // A disk's middle is 8 + 50 px from its side.
  EXPECT_LT(Grey(PixelAt(image, 58 + 25, 58)), 70.0);
  EXPECT_GT(Grey(PixelAt(image, 58 - 25, 58)), 150.0);
  EXPECT_GT(Grey(PixelAt(image, 166 + 25, 58)), 150.0);
  EXPECT_GT(Grey(PixelAt(image, 166 - 25, 58)), 150.0);
}

TEST(SphereRenderer, HigherWeightIsDarker) {
  SphereView view;
  view.radius_px = 50;
  view.towards = {0.0, 0.0, 1.0};
  const std::vector<SphereSample> samples = {{{0.5F, 0.0F, std::sqrt(0.75F)}, 2.0F},
                                             {{-0.5F, 0.0F, std::sqrt(0.75F)}, 1.0F}};
  const RgbImage image = RenderSphereDensity(samples, view);
  EXPECT_LT(Grey(PixelAt(image, 58 + 25, 58)), Grey(PixelAt(image, 58 - 25, 58)));
  EXPECT_LT(Grey(PixelAt(image, 58 - 25, 58)), Grey(PixelAt(image, 58 - 25, 30)));
}

TEST(SphereRenderer, NoWeightIsAnEmptyBall) {
  const RgbImage image = RenderSphereDensity({}, SphereView{});
  EXPECT_GT(Grey(PixelAt(image, 8 + 60, 8 + 110)), 150.0);
}

TEST(SphereRenderer, DirectionIsThePapersVectorTurned) {
  const double third = 1.0 / std::sqrt(3.0);
  EXPECT_LT((DirectionOfOrientation(Eigen::Quaterniond::Identity()) -
             Eigen::Vector3d(third, third, third))
                .norm(),
            1e-12);
  // A quarter turn about z takes x to y and y to -x.
  EXPECT_LT((DirectionOfOrientation(ExpSo3({0.0, 0.0, 90.0 * kDegree})) -
             Eigen::Vector3d(-third, third, third))
                .norm(),
            1e-12);
}

}  // namespace
}  // namespace vantage
