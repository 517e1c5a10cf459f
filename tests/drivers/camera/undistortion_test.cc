#include "drivers/camera/undistortion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace vantage {
namespace {

// An Xtion-like lens: some pixels at the corners.
const BrownConrady kLens = {0.05, -0.1, 0.002, -0.001, 0.02};

// Where the ray of a pixel of the distorted image falls in the ideal one: the distortion undone by
// fixed-point iteration.
Eigen::Vector2d IdealPixel(const CameraModel& camera, const BrownConrady& lens, int u, int v) {
  const auto [k1, k2, p1, p2, k3] = lens;
  const Eigen::Vector2d seen((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy);
  Eigen::Vector2d ideal = seen;
  for (int i = 0; i < 50; ++i) {
    const double x = ideal.x();
    const double y = ideal.y();
    const double r2 = ideal.squaredNorm();
    const Eigen::Vector2d tangential(2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
                                     p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y);
    ideal = (seen - tangential) / (1.0 + k1 * r2 + k2 * r2 * r2 + k3 * r2 * r2 * r2);
  }
  return {camera.fx * ideal.x() + camera.cx, camera.fy * ideal.y() + camera.cy};
}

TEST(Undistortion, PutsEveryRayWhereAnIdealCameraHasIt) {
  const CameraModel camera;
  // Two images whose values tell where in the ideal image each ray belongs, in 1/50 px.
  std::vector<uint16_t> tells_u;
  std::vector<uint16_t> tells_v;
  double farthest = 0.0;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector2d ideal = IdealPixel(camera, kLens, u, v);
      farthest = std::max(farthest, (ideal - Eigen::Vector2d(u, v)).norm());
      tells_u.push_back(static_cast<uint16_t>(std::lround(50.0 * (ideal.x() + 100.0))));
      tells_v.push_back(static_cast<uint16_t>(std::lround(50.0 * (ideal.y() + 100.0))));
    }
  }
  ASSERT_GT(farthest, 3.0);  // So it matters.
  const std::vector<int32_t> map = UndistortionMap(camera, kLens);
  const std::vector<uint16_t> ideal_u = Undistort(tells_u, map);
  const std::vector<uint16_t> ideal_v = Undistort(tells_v, map);
  size_t num_valid = 0;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const size_t i = static_cast<size_t>(v * camera.width + u);
      if (map[i] < 0) continue;
      ++num_valid;
      // Half a pixel for the nearest, a little for the lens's magnification and the rounding.
      ASSERT_NEAR(ideal_u[i] / 50.0 - 100.0, u, 0.56) << u << " " << v;
      ASSERT_NEAR(ideal_v[i] / 50.0 - 100.0, v, 0.56) << u << " " << v;
    }
  }
  EXPECT_GT(num_valid, map.size() * 9 / 10);
}

TEST(Undistortion, WithoutDistortionNothingMoves) {
  const CameraModel camera{.width = 7, .height = 5, .fx = 6.0, .fy = 6.0, .cx = 3.2, .cy = 1.9};
  std::vector<int32_t> expected(35);
  std::iota(expected.begin(), expected.end(), 0);
  EXPECT_EQ(UndistortionMap(camera, {}), expected);
}

TEST(Undistortion, BesideTheImageIsNoMeasurement) {
  const CameraModel camera{.width = 5, .height = 3, .fx = 4.0, .fy = 4.0, .cx = 2.0, .cy = 1.0};
  const std::vector<int32_t> map = UndistortionMap(camera, {2.0, 0.0, 0.0, 0.0, 0.0});
  EXPECT_EQ(map[0], -1);
  EXPECT_EQ(map[7], 7);
  const std::vector<uint16_t> depth(15, 900);
  EXPECT_EQ(Undistort(depth, map)[0], 0);
  EXPECT_EQ(Undistort(depth, map)[7], 900);
}

TEST(Undistortion, AbsurdCoefficientsStayInsideTheImage) {
  const CameraModel camera{.width = 64, .height = 48, .fx = 1.0, .fy = 1e6, .cx = -1e6, .cy = 1e6};
  for (const double k : {100.0, -100.0, 1e300, std::numeric_limits<double>::infinity()}) {
    for (const int32_t place : UndistortionMap(camera, {k, -k, k, k, -k})) {
      EXPECT_GE(place, -1);
      EXPECT_LT(place, 64 * 48);
    }
  }
}

}  // namespace
}  // namespace vantage
