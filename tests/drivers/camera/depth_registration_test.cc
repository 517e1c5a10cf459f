#include "drivers/camera/depth_registration.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/drivers/camera/traced_scene.h"

namespace vantage {
namespace {

const LensDistortion kLens{.k1 = 0.08, .k2 = -0.12, .p1 = 0.001, .p2 = -0.002, .k3 = 0.02};

CameraModel Model(int width, int height, double focal_length) {
  return {.width = width,
          .height = height,
          .fx = focal_length,
          .fy = 1.004 * focal_length,
          .cx = 0.5 * width + 3.2,
          .cy = 0.5 * height - 4.7};
}

Pose MakePose(const Eigen::Vector3d& position, const Eigen::Vector3d& turn_deg) {
  Pose pose = Pose::Identity();
  pose.linear() = ExpSo3(kDegree * turn_deg).toRotationMatrix();
  pose.translation() = position;
  return pose;
}

// Largest by smallest depth among the pixels around one, itself too; infinity with one of none.
double Relief(const std::vector<double>& depth, const CameraModel& camera, int u, int v) {
  constexpr int kReach = 2;  // px
  double nearest = 1e9;
  double farthest = 0.0;
  for (int y = v - kReach; y <= v + kReach; ++y) {
    for (int x = u - kReach; x <= u + kReach; ++x) {
      if (x < 0 || y < 0 || x >= camera.width || y >= camera.height) return 1e9;
      const double z = depth[static_cast<size_t>(y * camera.width + x)];
      nearest = std::min(nearest, z);
      farthest = std::max(farthest, z);
    }
  }
  return nearest > 0.0 ? farthest / nearest : 1e9;
}

// What became of the pixels of a registered image.
struct Comparison {
  int num_compared = 0;  // Smooth in both views, and seen by both cameras.
  int num_wrong = 0;     // Of these: farther than 2 mm from the truth, or empty.
  int num_hidden = 0;    // Smooth, but hidden from the depth camera.
  int num_invented = 0;  // More than 1 % before everything that there is, away from edges.
};

Comparison Compare(const CameraIntrinsics& depth_camera,
                   const CameraModel& color_camera,
                   const Pose& T_color_depth) {
  const TracedScene scene;
  const std::vector<double> depth = scene.Render(depth_camera, Pose::Identity());
  const std::vector<double> truth = scene.Render({color_camera, {}}, T_color_depth);
  DepthRegistration registration(depth_camera, color_camera, T_color_depth);
  std::vector<uint16_t> registered(7, 1);
  registration.Register(ToMillimetres(depth), &registered);

  Comparison found;
  EXPECT_EQ(registered.size(), truth.size());
  const CameraModel& pinhole = depth_camera.camera;
  for (int v = 0; v < color_camera.height; ++v) {
    for (int u = 0; u < color_camera.width; ++u) {
      const size_t i = static_cast<size_t>(v * color_camera.width + u);
      constexpr double kSmooth = 1.06;  // Of inclined surfaces over five pixels.
      if (Relief(truth, color_camera, u, v) > kSmooth) continue;
      const double z = 1e-3 * registered[i];
      if (z > 0.0 && z < 0.99 * truth[i]) ++found.num_invented;
      const Eigen::Vector3d p_depth =
          T_color_depth.inverse() * color_camera.Unproject(u, v, truth[i]);
      const Eigen::Vector2d shown =
          depth_camera.distortion.Distort(p_depth.head<2>() / p_depth.z());
      const int seen_u = static_cast<int>(std::lround(pinhole.fx * shown.x() + pinhole.cx));
      const int seen_v = static_cast<int>(std::lround(pinhole.fy * shown.y() + pinhole.cy));
      if (Relief(depth, pinhole, seen_u, seen_v) > kSmooth) continue;
      if (p_depth.z() > 1.02 * depth[static_cast<size_t>(seen_v * pinhole.width + seen_u)]) {
        ++found.num_hidden;
        continue;
      }
      ++found.num_compared;
      if (!(std::abs(z - truth[i]) <= 2e-3)) ++found.num_wrong;
    }
  }
  return found;
}

struct Case {
  const char* name;
  CameraIntrinsics depth;
  CameraModel color;
  Pose T_color_depth;
};

std::vector<Case> Cases() {
  const CameraIntrinsics vga{Model(640, 480, 570.0), {}};
  const Pose kinect = MakePose({-0.025, 0.001, 0.002}, {0.3, -0.5, 0.4});
  return {
      {"as a Kinect", vga, Model(640, 480, 525.0), kinect},
      {"the other way", vga, Model(640, 480, 525.0), kinect.inverse()},
      {"above, turned by 10 degrees",
       vga,
       Model(640, 480, 560.0),
       MakePose({0.01, 0.05, 0.0}, {-4.0, 2.0, 10.0})},
      {"upright", vga, Model(480, 640, 570.0), MakePose({0.03, 0.0, 0.0}, {0.0, 0.0, 90.0})},
      {"upside down", vga, Model(640, 480, 570.0), MakePose({0.0, 0.03, 0.0}, {0.0, 0.0, 180.0})},
      {"full HD",
       {Model(512, 424, 365.0), {}},
       Model(1920, 1080, 1060.0),
       MakePose({-0.052, 0.0, 0.0}, {0.2, 0.1, 0.0})},
      {"small", vga, Model(320, 240, 270.0), kinect},
      {"distorted depth", {vga.camera, kLens}, Model(640, 480, 525.0), kinect}};
}

TEST(DepthRegistration, IsWhatTheColorCameraWouldHaveTaken) {
  for (const Case& each : Cases()) {
    const Comparison found = Compare(each.depth, each.color, each.T_color_depth);
    EXPECT_GT(found.num_compared, each.color.width * each.color.height / 2) << each.name;
    EXPECT_LE(found.num_wrong, found.num_compared / 500) << each.name;
    EXPECT_GT(found.num_hidden, 100) << each.name;
    EXPECT_LE(found.num_invented, found.num_compared / 1000) << each.name;
  }
}

// The signs: a point straight ahead of the depth camera is at t = -R c of the color camera.
TEST(DepthRegistration, APixelGoesWhereItsPointProjects) {
  const CameraModel camera{
      .width = 41, .height = 31, .fx = 40.0, .fy = 40.0, .cx = 20.0, .cy = 15.0};
  std::vector<uint16_t> depth(41 * 31, 0);
  depth[15 * 41 + 20] = 1000;
  const struct {
    Pose T_color_depth;
    int u, v, z;
  } cases[] = {{Pose::Identity(), 20, 15, 1000},
               {MakePose({0.1, 0.0, 0.0}, {0.0, 0.0, 0.0}), 24, 15, 1000},
               {MakePose({0.0, -0.1, 0.0}, {0.0, 0.0, 0.0}), 20, 11, 1000},
               {MakePose({0.0, 0.0, 0.25}, {0.0, 0.0, 0.0}), 20, 15, 1250},
               // Turned about y, what was ahead lies to the right: tan(14.04 deg) = 0.25.
               {MakePose({0.0, 0.0, 0.0}, {0.0, 14.0362, 0.0}), 30, 15, 970}};
  for (const auto& each : cases) {
    DepthRegistration registration({camera, {}}, camera, each.T_color_depth);
    std::vector<uint16_t> registered;
    registration.Register(depth, &registered);
    for (size_t i = 0; i < registered.size(); ++i) {
      const bool is_there = i == static_cast<size_t>(each.v * 41 + each.u);
      EXPECT_EQ(registered[i], is_there ? each.z : 0) << i;
    }
  }
}

TEST(DepthRegistration, BetweenNearAndFarNothingIsInvented) {
  const CameraModel depth_camera{
      .width = 64, .height = 48, .fx = 60.0, .fy = 60.0, .cx = 31.5, .cy = 23.5};
  const CameraModel color_camera = depth_camera.Scaled(3.0);
  std::vector<uint16_t> depth(64 * 48, 2000);
  for (size_t v = 16; v < 32; ++v) std::fill_n(&depth[v * 64 + 20], 20, uint16_t{700});
  DepthRegistration registration(
      {depth_camera, {}}, color_camera, MakePose({0.04, 0.0, 0.0}, {0.0, 0.0, 0.0}));
  std::vector<uint16_t> registered;
  registration.Register(depth, &registered);
  int num_near = 0;
  int num_far = 0;
  int num_none = 0;
  for (const uint16_t z : registered) {
    EXPECT_TRUE(z == 700 || z == 2000 || z == 0) << z;
    (z == 700 ? num_near : z == 0 ? num_none : num_far) += 1;
  }
  EXPECT_NEAR(num_near, 20 * 16 * 9, 200);
  // Moved by 180 px * 0.04 m / z: what the near one uncovers nobody measured, and left of all.
  EXPECT_NEAR(num_none, (10.3 - 3.6) * 16 * 3 + 3.6 * 48 * 3, 150);
  EXPECT_EQ(num_near + num_far + num_none, 64 * 48 * 9);
}

TEST(DepthRegistration, AbsurdCalibrationsDoNoHarm) {
  const CameraModel camera{.width = 19, .height = 13, .fx = 1.0, .fy = 1e6, .cx = -1e6, .cy = 1e6};
  const std::vector<uint16_t> depth(19 * 13, 65535);
  for (const double k : {0.0, 100.0, -100.0}) {
    for (const double turn_deg : {0.0, 90.0, 180.0}) {
      DepthRegistration registration(
          {camera, {k, -k, k, k, -k}},
          {.width = 33, .height = 1, .fx = 1e6, .fy = 1.0, .cx = 1e6, .cy = -1e6},
          MakePose({1.0, -1.0, -0.5}, {0.0, turn_deg, 0.0}));
      std::vector<uint16_t> registered;
      registration.Register(depth, &registered);
      EXPECT_EQ(registered.size(), 33U);
    }
  }
}

TEST(DepthRegistration, AFrameLeavesNoTraceInTheNext) {
  const CameraModel camera;
  DepthRegistration registration({camera, {}}, camera, MakePose({0.02, 0.0, 0.0}, {0.0, 0.0, 1.0}));
  std::vector<uint16_t> first;
  std::vector<uint16_t> again;
  const std::vector<uint16_t> depth =
      ToMillimetres(TracedScene().Render({camera, {}}, Pose::Identity()));
  registration.Register(depth, &first);
  registration.Register(std::vector<uint16_t>(depth.size(), 400), &again);
  registration.Register(std::vector<uint16_t>(depth.size(), 0), &again);
  EXPECT_EQ(again, std::vector<uint16_t>(depth.size(), 0));
  registration.Register(depth, &again);
  EXPECT_EQ(again, first);
}

}  // namespace
}  // namespace vantage
