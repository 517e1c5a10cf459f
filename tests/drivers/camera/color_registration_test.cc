#include "drivers/camera/color_registration.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/drivers/camera/traced_scene.h"

namespace vantage {
namespace {

// Paint of a point of the scene, in the depth camera's frame.
double Paint(const Eigen::Vector3d& p_depth, int channel) {
  return 128.0 + 80.0 * std::sin(25.0 * p_depth.x() + channel) *
                     std::cos(20.0 * p_depth.y() + 9.0 * p_depth.z() - channel);
}

std::vector<uint8_t> TakePicture(const CameraIntrinsics& color,
                                 const Pose& T_color_depth,
                                 int channels) {
  const Pose T_depth_color = T_color_depth.inverse();
  const CameraModel& camera = color.camera;
  const std::vector<double> depth = TracedScene().Render(color, T_color_depth);
  std::vector<uint8_t> pixels;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const double z = depth[static_cast<size_t>(v * camera.width + u)];
      const auto ideal =
          color.distortion.Undistort({(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy});
      const Eigen::Vector3d p_color = z * ideal.value_or(Eigen::Vector2d(0.0, 0.0)).homogeneous();
      for (int c = 0; c < channels; ++c) {
        pixels.push_back(static_cast<uint8_t>(std::lround(Paint(T_depth_color * p_color, c))));
      }
    }
  }
  return pixels;
}

TEST(ColorRegistration, PaintsWhatBothCamerasSeeAndNothingElse) {
  const TracedScene scene;
  const CameraModel depth;
  Pose T_color_depth = Pose::Identity();
  T_color_depth.linear() = ExpSo3(kDegree * Eigen::Vector3d(0.4, -1.0, 2.0)).toRotationMatrix();
  T_color_depth.translation() << -0.05, 0.01, 0.003;
  const Eigen::Vector3d eye = T_color_depth.inverse().translation();
  const std::vector<double> truth = scene.Render({depth, {}}, Pose::Identity());
  const LensDistortion lens{.k1 = 0.1, .k2 = -0.2, .p1 = 0.002, .p2 = 0.001, .k3 = 0.0};
  for (const LensDistortion& distortion : {LensDistortion{}, lens}) {
    for (const int channels : {1, 3}) {
      const CameraIntrinsics color{{800, 600, 640.0, 642.0, 402.0, 296.0}, distortion};
      ColorRegistration registration(depth, color, T_color_depth);
      std::vector<uint8_t> registered;
      registration.Register(
          ToMillimetres(truth), channels, TakePicture(color, T_color_depth, channels), &registered);
      ASSERT_EQ(registered.size(), static_cast<size_t>(channels) * truth.size());
      int num_seen = 0;
      int num_unpainted = 0;
      int num_wrong = 0;
      int num_hidden = 0;
      int num_painted_hidden = 0;
      for (size_t i = 0; i < truth.size(); ++i) {
        const int u = static_cast<int>(i) % depth.width;
        const int v = static_cast<int>(i) / depth.width;
        const Eigen::Vector3d point = depth.Unproject(u, v, truth[i]);
        const Eigen::Vector2d shown = color.camera.Project(T_color_depth * point);
        if (shown.x() < 40 || shown.y() < 40 || shown.x() > 760 || shown.y() > 560) continue;
        const Eigen::Vector3d first = scene.Trace(eye, point - eye).value();
        const bool is_hidden = (first - eye).norm() < 0.97 * (point - eye).norm();
        const uint8_t* pixel = &registered[i * static_cast<size_t>(channels)];
        if (is_hidden) {
          ++num_hidden;
          num_painted_hidden += pixel[0] == 0 ? 0 : 1;
          continue;
        }
        ++num_seen;
        num_unpainted += pixel[0] == 0 ? 1 : 0;
        for (int c = 0; c < channels && pixel[0] != 0; ++c) {
          if (std::abs(pixel[c] - Paint(point, c)) > 4.0) {
            ++num_wrong;
            break;
          }
        }
      }
      EXPECT_GT(num_seen, 200'000);
      EXPECT_LE(num_wrong, num_seen / 100);
      EXPECT_LE(num_unpainted, num_seen / 100);
      EXPECT_GT(num_hidden, 1000);
      EXPECT_LE(num_painted_hidden, num_hidden / 20);
    }
  }
}

TEST(ColorRegistration, WithoutAMeasurementThereIsNoColor) {
  const CameraModel camera{.width = 9, .height = 3, .fx = 8.0, .fy = 8.0, .cx = 4.0, .cy = 1.0};
  ColorRegistration registration(camera, {camera, {}}, Pose::Identity());
  std::vector<uint16_t> depth(27, 1000);
  depth[13] = 0;
  std::vector<uint8_t> registered;
  registration.Register(depth, 3, std::vector<uint8_t>(81, 50), &registered);
  std::vector<uint8_t> expected(81, 50);
  for (size_t c = 0; c < 3; ++c) expected[39 + c] = 0;
  EXPECT_EQ(registered, expected);
}

}  // namespace
}  // namespace vantage
