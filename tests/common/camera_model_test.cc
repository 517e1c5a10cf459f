#include "common/camera_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "common/rng.h"
#include "common/so3.h"

namespace vantage {
namespace {

TEST(CameraModel, UnprojectInvertsProject) {
  const CameraModel camera{
      .width = 640, .height = 480, .fx = 550.0, .fy = 545.0, .cx = 320.7, .cy = 241.2};
  Rng rng(1);
  for (int i = 0; i < 200; ++i) {
    const double u = rng.Uniform(-100.0, 800.0);
    const double v = rng.Uniform(-100.0, 600.0);
    const double depth = rng.Uniform(0.1, 10.0);
    const Eigen::Vector3d p_camera = camera.Unproject(u, v, depth);
    EXPECT_EQ(p_camera.z(), depth);
    EXPECT_LE((camera.Project(p_camera) - Eigen::Vector2d(u, v)).norm(), 1e-11);
  }
}

TEST(CameraModel, AxesAreRightDownForward) {
  const CameraModel camera;
  const Eigen::Vector2d middle = camera.Project({0.0, 0.0, 1.0});
  EXPECT_EQ(middle, Eigen::Vector2d(camera.cx, camera.cy));
  EXPECT_GT(camera.Project({0.1, 0.0, 1.0}).x(), middle.x());
  EXPECT_GT(camera.Project({0.0, 0.1, 1.0}).y(), middle.y());
}

TEST(CameraModel, ScaledSeesTheSameRays) {
  const CameraModel camera{
      .width = 640, .height = 480, .fx = 550.0, .fy = 545.0, .cx = 320.7, .cy = 241.2};
  for (const double factor : {0.5, 2.0, 0.25}) {
    const CameraModel scaled = camera.Scaled(factor);
    EXPECT_EQ(scaled.width, std::lround(640 * factor));
    EXPECT_EQ(scaled.height, std::lround(480 * factor));
    // The image's corners, half a pixel outside the first and last pixel's centres, stay corners.
    for (const double x : {-0.5, 639.5}) {
      const Eigen::Vector3d ray = camera.Unproject(x, -0.5, 1.0);
      const Eigen::Vector2d corner = scaled.Project(ray);
      EXPECT_NEAR(corner.x(), (x + 0.5) * factor - 0.5, 1e-9);
      EXPECT_NEAR(corner.y(), -0.5, 1e-9);
    }
  }
  EXPECT_EQ(camera.Scaled(1.0), camera);
}

TEST(CameraModel, FieldOfViewReachesTheImagesCorners) {
  const double horizontal = 58.0 * kDegree;
  const double vertical = 45.0 * kDegree;
  const CameraModel camera = CameraFromFieldOfView(640, 480, horizontal, vertical);
  ASSERT_TRUE(camera.Validate().ok());
  const Eigen::Vector3d left = camera.Unproject(-0.5, 239.5, 1.0);
  const Eigen::Vector3d right = camera.Unproject(639.5, 239.5, 1.0);
  EXPECT_NEAR(std::atan(right.x()) - std::atan(left.x()), horizontal, 1e-12);
  const Eigen::Vector3d top = camera.Unproject(319.5, -0.5, 1.0);
  const Eigen::Vector3d bottom = camera.Unproject(319.5, 479.5, 1.0);
  EXPECT_NEAR(std::atan(bottom.y()) - std::atan(top.y()), vertical, 1e-12);
}

TEST(CameraModel, ValidateNamesWhatIsWrong) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  const auto message = [](CameraModel camera) {
    const Result<void> result = camera.Validate();
    return result.ok() ? std::string() : result.error().message;
  };
  EXPECT_EQ(message({}), "");
  EXPECT_NE(message({.width = 0}).find("0 x 480"), std::string::npos);
  EXPECT_NE(message({.height = 16385}).find("16385"), std::string::npos);
  EXPECT_NE(message({.fx = -1.0}).find("fx = -1"), std::string::npos);
  EXPECT_NE(message({.fy = 0.0}).find("fy = 0"), std::string::npos);
  EXPECT_NE(message({.fx = nan}), "");
  EXPECT_NE(message({.fy = infinity}), "");
  EXPECT_NE(message({.cx = nan}).find("principal point"), std::string::npos);
  EXPECT_NE(message({.cy = -infinity}), "");
  // Finite, but not what one can reckon with.
  EXPECT_NE(message({.fx = 5e-324}), "");
  EXPECT_NE(message({.fy = 1e308}), "");
  EXPECT_NE(message({.cx = 1e308}), "");
  EXPECT_NE(message({.cy = -1e308}), "");
}

}  // namespace
}  // namespace vantage
