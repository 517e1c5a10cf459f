// Drawn depth images and shaded scenes: what is drawn lies where the camera sees it.

#include "tools/support/depth_view.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "common/rng.h"
#include "tools/support/rgb_canvas.h"
#include "tools/support/shaded_scene.h"
#include "tools/support/smooth_normals.h"

namespace vantage {
namespace {

constexpr Rgb kOutline{255, 0, 0};

CameraModel SmallCamera() { return {320, 240, 300.0, 310.0, 159.5, 119.5}; }

// A box about the origin; its upper side is at z = 0 of TableMesh.
TriangleMesh Box(double size_x, double size_y, double size_z) {
  return TableMesh({0.0, 0.0, 0.5 * size_z}, size_x, size_y, size_z);
}

Pose At(double x, double y, double z) { return Pose(Eigen::Translation3d(x, y, z)); }

bool IsNear(const RgbImage& image, int u, int v, int reach, Rgb color) {
  for (int dv = -reach; dv <= reach; ++dv) {
    for (int du = -reach; du <= reach; ++du) {
      const int x = u + du;
      const int y = v + dv;
      if (x < 0 || y < 0 || x >= image.width || y >= image.height) continue;
      if (PixelAt(image, x, y) == color) return true;
    }
  }
  return false;
}

TEST(CutCamera, ShowsTheWindowInTheMiddle) {
  const CameraModel camera = SmallCamera();
  Rng rng(1);
  for (int i = 0; i < 50; ++i) {
    PixelWindow window;
    window.u0 = static_cast<int>(rng.Below(300)) - 30;
    window.v0 = static_cast<int>(rng.Below(200)) - 30;
    window.u1 = window.u0 + static_cast<int>(rng.Below(100));
    window.v1 = window.v0 + static_cast<int>(rng.Below(100));
    const CameraModel cut = CutCamera(camera, window, 200, 150);
    EXPECT_EQ(cut.width, 200);
    EXPECT_EQ(cut.height, 150);
    EXPECT_NEAR(cut.fx / cut.fy, camera.fx / camera.fy, 1e-12);
    // The rays of the window's outer corners touch the picture's sides, two of them at least.
    const Eigen::Vector2d low = cut.Project(camera.Unproject(window.u0 - 0.5, window.v0 - 0.5, 1));
    const Eigen::Vector2d high = cut.Project(camera.Unproject(window.u1 + 0.5, window.v1 + 0.5, 1));
    EXPECT_NEAR((0.5 * (low + high) - Eigen::Vector2d(99.5, 74.5)).norm(), 0.0, 1e-9);
    const Eigen::Vector2d size = high - low;
    EXPECT_LE(size.x(), 200.0 + 1e-9);
    EXPECT_LE(size.y(), 150.0 + 1e-9);
    EXPECT_TRUE(size.x() > 200.0 - 1e-9 || size.y() > 150.0 - 1e-9);
  }
}

TEST(DepthView, OutlineLiesAtTheProjectedSilhouette) {
  const CameraModel camera = SmallCamera();
  const TriangleMesh box = Box(0.2, 0.1, 0.02);
  // Its near side is a rectangle at z = 0.79 m.
  const DepthImage depth(camera.width, camera.height, 0.79F);
  const DepthView view =
      DrawDepthView(depth, camera, {{&box, At(0.05, -0.02, 0.8), kOutline}}, 400, 300);
  ASSERT_EQ(view.image.width, 400);
  ASSERT_EQ(view.image.height, 300);
  ASSERT_EQ(view.windows.size(), 1U);
  const PixelWindow& window = view.windows[0];
  // The picture's scale follows from the window's width and the known one in the depth image.
  const Eigen::Vector2d low = camera.Project({-0.05, -0.07, 0.79});
  const Eigen::Vector2d high = camera.Project({0.15, 0.03, 0.79});
  const double scale = (window.u1 - window.u0 + 1) / (high.x() - low.x());
  EXPECT_NEAR((window.v1 - window.v0 + 1) / (high.y() - low.y()), scale, 0.03 * scale);
  EXPECT_GT(scale, 1.2) << "cut to the model";
  EXPECT_NEAR(0.5 * (window.u0 + window.u1), 199.5, 2.0);
  EXPECT_NEAR(0.5 * (window.v0 + window.v1), 149.5, 2.0);

  for (int v = 0; v < view.image.height; ++v) {
    for (int u = 0; u < view.image.width; ++u) {
      const int outside = std::max({window.u0 - u, u - window.u1, window.v0 - v, v - window.v1});
      // Colored pixels only within 2 px of the rectangle's border, and all along it.
      if (PixelAt(view.image, u, v) == kOutline) {
        EXPECT_LE(std::abs(outside), 2) << u << " " << v;
      }
      if (outside == 0) {
        EXPECT_TRUE(IsNear(view.image, u, v, 1, kOutline)) << u << " " << v;
      }
    }
  }
}

TEST(DepthView, ColorsTellTheDepth) {
  const CameraModel camera = SmallCamera();
  DepthImage depth(camera.width, camera.height, 1.0F);
  for (int v = 0; v < 120; ++v) {
    for (int u = 0; u < 320; ++u) depth.at(u, v) = u < 160 ? 2.0F : DepthImage::kInvalid;
  }
  const DepthView view = DrawDepthView(depth, camera, {}, 320, 240);
  EXPECT_DOUBLE_EQ(view.near, 1.0);
  EXPECT_DOUBLE_EQ(view.far, 2.0);
  EXPECT_TRUE(view.windows.empty());
  EXPECT_EQ(PixelAt(view.image, 10, 10), DepthColor(1.0));
  EXPECT_EQ(PixelAt(view.image, 159, 119), DepthColor(1.0));
  EXPECT_EQ(PixelAt(view.image, 159, 120), DepthColor(0.0));
  EXPECT_EQ(PixelAt(view.image, 300, 239), DepthColor(0.0));
  const Rgb none = PixelAt(view.image, 300, 10);
  EXPECT_NEAR(none.r, none.b, 10) << "grey where nothing was measured";
  EXPECT_LT(none.r, 80);
}

TEST(DepthView, NoDepthAndNoModelInViewAreDrawnToo) {
  const CameraModel camera = SmallCamera();
  const TriangleMesh box = Box(0.2, 0.1, 0.02);
  const DepthImage depth(camera.width, camera.height);
  const DepthView view =
      DrawDepthView(depth,
                    camera,
                    {{&box, At(0.0, 0.0, -1.0), kOutline}, {&box, At(9.0, 0.0, 1.0), kOutline}},
                    400,
                    200);
  ASSERT_EQ(view.windows.size(), 2U);
  EXPECT_TRUE(view.windows[0].empty());
  EXPECT_TRUE(view.windows[1].empty());
  std::set<std::string> colors;
  for (int u = 0; u < 400; ++u) colors.insert(HexColor(PixelAt(view.image, u, 100)));
  EXPECT_EQ(colors.size(), 1U);
}

TEST(SmoothNormals, KeepCreasesAndRoundOffTheRest) {
  const TriangleMesh box = Box(0.2, 0.1, 0.3);
  const SmoothNormals flat(box);
  for (size_t t = 0; t < box.triangles.size(); ++t) {
    const Eigen::Vector3f expected = box.ScaledNormal(t).normalized();
    for (const uint32_t vertex : box.triangles[t]) {
      EXPECT_LT((flat.At(t, box.vertices[vertex]) - expected).norm(), 1e-5F);
    }
  }

  // A ball of 24 x 12 faces: normals bend by up to 15 degrees from face to face.
  TriangleMesh ball;
  for (int i = 0; i <= 12; ++i) {
    for (int j = 0; j < 24; ++j) {
      const double latitude = (i - 6) * 15.0 * kDegree;
      const double longitude = j * 15.0 * kDegree;
      ball.vertices.emplace_back(static_cast<float>(std::cos(latitude) * std::cos(longitude)),
                                 static_cast<float>(std::cos(latitude) * std::sin(longitude)),
                                 static_cast<float>(std::sin(latitude)));
    }
  }
  for (uint32_t i = 1; i < 11; ++i) {
    for (uint32_t j = 0; j < 24; ++j) {
      const uint32_t next = (j + 1) % 24;
      ball.triangles.push_back({24 * i + j, 24 * i + next, 24 * (i + 1) + next});
      ball.triangles.push_back({24 * i + j, 24 * (i + 1) + next, 24 * (i + 1) + j});
    }
  }
  const SmoothNormals smooth(ball);
  double worst_smooth = 0.0;
  double worst_flat = 0.0;
  for (size_t t = 24 * 2; t + 24 * 2 < ball.triangles.size(); ++t) {  // Not at the open rims.
    for (const uint32_t vertex : ball.triangles[t]) {
      const Eigen::Vector3f& p = ball.vertices[vertex];
      const Eigen::Vector3f normal = smooth.At(t, p);
      EXPECT_NEAR(normal.norm(), 1.0F, 1e-5F);
      worst_smooth = std::max(worst_smooth, std::acos(std::min(1.0, double{normal.dot(p)})));
      const Eigen::Vector3f face = ball.ScaledNormal(t).normalized();
      worst_flat = std::max(worst_flat, std::acos(std::min(1.0, double{face.dot(p)})));
    }
  }
  EXPECT_GT(worst_flat, 8.0 * kDegree);
  EXPECT_LT(worst_smooth, 3.0 * kDegree);
}

TEST(SmoothNormals, DegenerateTrianglesHaveUnitNormals) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 0, 0}};
  const SmoothNormals normals(mesh);
  for (size_t t = 0; t < 2; ++t) EXPECT_NEAR(normals.At(t, {0.5F, 0, 0}).norm(), 1.0F, 1e-5F);
}

TEST(ShadedScene, ThingsAreWhereTheCameraSeesThem) {
  const CameraModel camera = SmallCamera();
  const Pose T_world_camera = LookAt({0.5, -0.9, 0.7}, {0.0, 0.0, 0.0});
  const TriangleMesh box = Box(0.2, 0.1, 0.15);
  Pose T_world_box = Pose::Identity();
  T_world_box.linear() = ExpSo3({0.3, -0.5, 0.8}).toRotationMatrix();
  const RgbImage empty = RenderShaded({}, camera, T_world_camera);
  ASSERT_EQ(empty.width, camera.width);
  ASSERT_EQ(empty.height, camera.height);
  const RgbImage picture = RenderShaded(
      {.items = {{&box, T_world_box, {200, 40, 30}}}, .lines = {}}, camera, T_world_camera);
  DepthRasterizer rasterizer(camera);
  rasterizer.Clear();
  rasterizer.Draw(box, T_world_camera.inverse() * T_world_box);
  const auto drawn = [&](int u, int v) {
    const auto at = static_cast<size_t>(v * camera.width + u);
    return rasterizer.depth()[at] != DepthRasterizer::kEmpty;
  };
  int inside = 0;
  for (int v = 1; v + 1 < camera.height; ++v) {
    for (int u = 1; u + 1 < camera.width; ++u) {
      int around = 0;
      for (int i = 0; i < 9; ++i) around += drawn(u + i % 3 - 1, v + i / 3 - 1) ? 1 : 0;
      const Rgb color = PixelAt(picture, u, v);
      if (around == 9) {
        ++inside;
        EXPECT_GT(color.r, 2 * color.g) << u << " " << v;
      } else if (around == 0) {
        EXPECT_EQ(color, PixelAt(empty, u, v)) << u << " " << v;
      }
    }
  }
  EXPECT_GT(inside, 1000);
}

TEST(ShadedScene, LinesPassBehindFaintly) {
  const CameraModel camera = SmallCamera();
  const TriangleMesh box = Box(0.2, 0.2, 0.2);
  const Rgb blue{0, 0, 255};
  // Seen from above, camera x is world x: one line before the box, one behind it.
  const Pose T_world_camera = LookAt({0.0, 0.0, 1.0}, {0.0, 0.0, 0.0}, {0.0, 1.0, 0.0});
  const auto color_with = [&](double z) {
    ShadedScene scene;
    scene.items = {{&box, Pose::Identity(), {128, 128, 128}}};
    scene.lines = {{{-0.3, 0.0, z}, {0.3, 0.0, z}, 3.0, blue}};
    const RgbImage image = RenderShaded(scene, camera, T_world_camera);
    EXPECT_EQ(PixelAt(image, 20, 20).r,
              PixelAt(RenderShaded({}, camera, T_world_camera), 20, 20).r);
    return PixelAt(image, 160, 120);
  };
  EXPECT_EQ(color_with(0.3), blue);
  const Rgb hidden = color_with(-0.3);
  EXPECT_GT(hidden.r, 60);
  EXPECT_GT(hidden.b, hidden.r + 10);
}

TEST(ShadedScene, FrustumIsTheCamerasFieldOfView) {
  const CameraModel camera = SmallCamera();
  const Pose T_world_camera = LookAt({0.5, -0.9, 0.7}, {0.1, 0.2, 0.3});
  const auto lines = FrustumLines(camera, T_world_camera, 0.25, 1.0, kOutline);
  int from_eye = 0;
  int corners = 0;
  for (const ShadedLine& line : lines) {
    const Eigen::Vector3d from = T_world_camera.inverse() * line.from;
    const Eigen::Vector3d to = T_world_camera.inverse() * line.to;
    from_eye += from.norm() < 1e-9 ? 1 : 0;
    EXPECT_NEAR(to.z(), 0.25, 1e-9);
    const Eigen::Vector2d pixel = camera.Project(to);
    const bool at_side = std::min(std::abs(pixel.x() + 0.5), std::abs(pixel.x() - 319.5)) < 1e-6;
    const bool at_end = std::min(std::abs(pixel.y() + 0.5), std::abs(pixel.y() - 239.5)) < 1e-6;
    corners += at_side && at_end && from.norm() < 1e-9 ? 1 : 0;
    // The notch, which tells what is up, is above the image.
    if (!at_end) {
      EXPECT_LT(pixel.y(), -10.0);
    }
  }
  EXPECT_EQ(from_eye, 4);
  EXPECT_EQ(corners, 4);
}

TEST(ShadedScene, TableTopIsClosedAndWhereItShouldBe) {
  const TriangleMesh table = TableMesh({0.1, 0.2, 0.7}, 1.2, 0.8, 0.05);
  EXPECT_LT((table.Bounds().min() - Eigen::Vector3f(-0.5F, -0.2F, 0.65F)).norm(), 1e-6F);
  EXPECT_LT((table.Bounds().max() - Eigen::Vector3f(0.7F, 0.6F, 0.7F)).norm(), 1e-6F);
  EXPECT_NEAR(table.Area(), 2 * (1.2 * 0.8 + 1.2 * 0.05 + 0.8 * 0.05), 1e-6);
  // Outward: the volume by the divergence theorem is that of the plate.
  double volume = 0.0;
  for (size_t t = 0; t < table.triangles.size(); ++t) {
    const Eigen::Vector3f& a = table.vertices[table.triangles[t][0]];
    volume += a.cast<double>().dot(table.ScaledNormal(t).cast<double>()) / 6.0;
  }
  EXPECT_NEAR(volume, 1.2 * 0.8 * 0.05, 1e-6);
}

}  // namespace
}  // namespace vantage
