#include "drivers/camera/undistortion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace vantage {
namespace {

// An Xtion-like lens: some pixels at the corners.
const LensDistortion kLens{.k1 = 0.05, .k2 = -0.1, .p1 = 0.002, .p2 = -0.001, .k3 = 0.02};

// Where the ray of a pixel of the distorted image falls in the ideal one: the distortion undone by
// fixed-point iteration.
Eigen::Vector2d IdealPixel(const CameraIntrinsics& intrinsics, int u, int v) {
  const auto& [camera, lens] = intrinsics;
  const Eigen::Vector2d seen((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy);
  Eigen::Vector2d ideal = seen;
  for (int i = 0; i < 50; ++i) {
    const double x = ideal.x();
    const double y = ideal.y();
    const double r2 = ideal.squaredNorm();
    const Eigen::Vector2d tangential(2.0 * lens.p1 * x * y + lens.p2 * (r2 + 2.0 * x * x),
                                     lens.p1 * (r2 + 2.0 * y * y) + 2.0 * lens.p2 * x * y);
    ideal = (seen - tangential) / (1.0 + lens.k1 * r2 + lens.k2 * r2 * r2 + lens.k3 * r2 * r2 * r2);
  }
  return {camera.fx * ideal.x() + camera.cx, camera.fy * ideal.y() + camera.cy};
}

// A picture without small parts, of a pixel of the ideal image.
double Brightness(double u, double v, int channel) {
  return 128.0 + 100.0 * std::sin(0.05 * u + 2.0 * channel) * std::cos(0.04 * v - channel);
}

TEST(Undistortion, PutsEveryRayWhereAnIdealCameraHasIt) {
  const CameraModel camera;
  const CameraIntrinsics intrinsics{camera, kLens};
  // Two images whose values tell where in the ideal image each ray belongs, in 1/50 px.
  std::vector<uint16_t> tells_u;
  std::vector<uint16_t> tells_v;
  double farthest = 0.0;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector2d ideal = IdealPixel(intrinsics, u, v);
      farthest = std::max(farthest, (ideal - Eigen::Vector2d(u, v)).norm());
      tells_u.push_back(static_cast<uint16_t>(std::lround(50.0 * (ideal.x() + 100.0))));
      tells_v.push_back(static_cast<uint16_t>(std::lround(50.0 * (ideal.y() + 100.0))));
    }
  }
  ASSERT_GT(farthest, 3.0);  // So it matters.
  const std::vector<int32_t> map = UndistortionMap(intrinsics);
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
  EXPECT_EQ(UndistortionMap({camera, {}}), expected);
}

TEST(Undistortion, BesideTheImageIsNoMeasurement) {
  const CameraModel camera{.width = 5, .height = 3, .fx = 4.0, .fy = 4.0, .cx = 2.0, .cy = 1.0};
  const std::vector<int32_t> map = UndistortionMap({camera, {.k1 = 2.0}});
  EXPECT_EQ(map[0], -1);
  EXPECT_EQ(map[7], 7);
  const std::vector<uint16_t> depth(15, 900);
  EXPECT_EQ(Undistort(depth, map)[0], 0);
  EXPECT_EQ(Undistort(depth, map)[7], 900);
}

TEST(ImageUndistortion, InterpolatesWhatAnIdealCameraSees) {
  const CameraIntrinsics intrinsics{CameraModel{}, kLens};
  const CameraModel& camera = intrinsics.camera;
  for (const int channels : {1, 3}) {
    std::vector<uint8_t> pixels;
    for (int v = 0; v < camera.height; ++v) {
      for (int u = 0; u < camera.width; ++u) {
        const Eigen::Vector2d ideal = IdealPixel(intrinsics, u, v);
        for (int c = 0; c < channels; ++c) {
          pixels.push_back(static_cast<uint8_t>(std::lround(Brightness(ideal.x(), ideal.y(), c))));
        }
      }
    }
    ImageUndistortion(intrinsics).Undistort(channels, &pixels);
    int num_seen = 0;
    for (int v = 0; v < camera.height; ++v) {
      for (int u = 0; u < camera.width; ++u) {
        for (int c = 0; c < channels; ++c) {
          const uint8_t pixel = pixels[static_cast<size_t>((v * camera.width + u) * channels + c)];
          if (pixel == 0) continue;
          ++num_seen;
          // Rounding, twice, the shares' rounding, and half a pixel at the border.
          ASSERT_NEAR(pixel, Brightness(u, v, c), 4.0) << u << " " << v;
        }
      }
    }
    EXPECT_GT(num_seen, channels * camera.width * camera.height * 9 / 10);
  }
}

TEST(ImageUndistortion, WithoutDistortionNothingChanges) {
  for (const auto& [width, height] : {std::pair{7, 5}, std::pair{1, 1}, std::pair{1, 9}}) {
    const CameraModel camera{
        .width = width, .height = height, .fx = 6.0, .fy = 6.0, .cx = 3.2, .cy = 1.9};
    ImageUndistortion undistortion({camera, {}});
    for (const int channels : {1, 3}) {
      std::vector<uint8_t> pixels(static_cast<size_t>(channels * width * height));
      std::iota(pixels.begin(), pixels.end(), uint8_t{100});
      std::vector<uint8_t> undistorted = pixels;
      undistortion.Undistort(channels, &undistorted);
      EXPECT_EQ(undistorted, pixels);
    }
  }
}

TEST(Undistortion, AbsurdCoefficientsStayInsideTheImage) {
  const CameraModel camera{.width = 64, .height = 48, .fx = 1.0, .fy = 1e6, .cx = -1e6, .cy = 1e6};
  for (const double k : {100.0, -100.0, 1e300, std::numeric_limits<double>::infinity()}) {
    const CameraIntrinsics absurd{camera, {k, -k, k, k, -k}};
    for (const int32_t place : UndistortionMap(absurd)) {
      EXPECT_GE(place, -1);
      EXPECT_LT(place, 64 * 48);
    }
    std::vector<uint8_t> pixels(3 * 64 * 48, 200);
    ImageUndistortion(absurd).Undistort(3, &pixels);
    EXPECT_LE(*std::ranges::max_element(pixels), 200);
  }
}

}  // namespace
}  // namespace vantage
