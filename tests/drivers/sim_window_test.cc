#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "common/rng.h"
#include "drivers/sim/scene_renderer.h"
#include "drivers/sim/sensor_model.h"

namespace vantage {
namespace {

// Two bodies of large triangles, one behind the other, before a wall.
SimScene Scene() {
  SimScene scene;
  scene.floor = SimPlane{0.0, {8.0, 8.0}, {0.0, 0.0}};
  TriangleMesh tetrahedron;
  tetrahedron.vertices = {
      {0.08F, 0.0F, 0.0F}, {-0.05F, 0.07F, 0.01F}, {-0.04F, -0.06F, 0.0F}, {0.01F, 0.0F, 0.09F}};
  tetrahedron.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  for (const double height : {0.15, 0.30}) {
    Pose place = Pose::Identity();
    place.translation() = Eigen::Vector3d(0.1 * height, -0.02, height);
    scene.objects.push_back({"tetrahedron", tetrahedron, place});
  }
  return scene;
}

Pose Camera(Rng& rng) {
  return LookAt(Eigen::Vector3d(0.05, -0.1, 1.1), Eigen::Vector3d(0.02, 0.0, 0.2)) *
         Eigen::AngleAxisd(rng.Uniform(0.0, 6.0), Eigen::Vector3d::UnitZ());
}

// Bits of the pixels of the outer image's window `inner` that are `margin` px from its border.
std::vector<uint32_t> Cut(const DepthImage& image,
                          const PixelWindow& outer,
                          const PixelWindow& inner,
                          int margin) {
  std::vector<uint32_t> bits;
  for (int v = inner.v0 + margin; v <= inner.v1 - margin; ++v) {
    for (int u = inner.u0 + margin; u <= inner.u1 - margin; ++u) {
      const float z = image.at(u - outer.u0, v - outer.v0);
      bits.push_back(0);
      if (!std::isnan(z)) std::memcpy(&bits.back(), &z, sizeof(z));
    }
  }
  return bits;
}

constexpr PixelWindow kWindow = {208, 112, 455, 371};

TEST(SceneWindow, IsCutFromTheWholeImage) {
  Rng rng(1);
  const CameraModel camera;
  SceneRenderer whole(Scene(), camera);
  SceneRenderer part(Scene(), camera);
  for (int i = 0; i < 3; ++i) {
    const Pose T_world_camera = Camera(rng);
    const RenderedView& all = whole.Render(T_world_camera);
    // Windows in turn with the whole: nothing is left over from the image before.
    part.Render(T_world_camera);
    const RenderedView& cut = part.Render(T_world_camera, kWindow);
    EXPECT_EQ(cut.window, kWindow);
    ASSERT_EQ(cut.depth.width, kWindow.width());
    ASSERT_EQ(cut.depth.height, kWindow.height());
    EXPECT_EQ(Cut(all.depth, all.window, kWindow, 0), Cut(cut.depth, cut.window, kWindow, 0));
    int objects = 0;
    for (int v = kWindow.v0; v <= kWindow.v1; ++v) {
      for (int u = kWindow.u0; u <= kWindow.u1; ++u) {
        const size_t a = all.depth.Index(u, v);
        const size_t b = cut.depth.Index(u - kWindow.u0, v - kWindow.v0);
        ASSERT_EQ(all.surface[a], cut.surface[b]);
        ASSERT_EQ(all.cos_incidence[a], cut.cos_incidence[b]);
        objects += cut.surface[b] < 2 ? 1 : 0;
      }
    }
    EXPECT_GT(objects, 3000);
  }
}

TEST(SceneWindow, AnObjectMoves) {
  SimScene scene = Scene();
  SceneRenderer moved(scene, {});
  const Pose place(Eigen::Translation3d(-0.05, 0.03, 0.4));
  moved.MoveObject(1, place);
  scene.objects[1].T_world_object = place;
  SceneRenderer there(scene, {});
  Rng rng(2);
  const Pose T_world_camera = Camera(rng);
  const PixelWindow all = WholeImage({});
  EXPECT_EQ(Cut(moved.Render(T_world_camera).depth, all, all, 0),
            Cut(there.Render(T_world_camera).depth, all, all, 0));
}

TEST(SensorWindow, IsCutFromTheWholeImage) {
  Rng rng(3);
  const CameraModel camera;
  SceneRenderer whole(Scene(), camera);
  SceneRenderer part(Scene(), camera);
  SensorModelParameters parameters;
  parameters.seed = 5;
  parameters.device_id = 77;
  SensorModel whole_sensor(parameters, camera);
  SensorModel part_sensor(parameters, camera);
  DepthImage all, cut;
  for (int frame = 0; frame < 3; ++frame) {
    const Pose T_world_camera = Camera(rng);
    whole_sensor.Measure(whole.Render(T_world_camera), frame, 40.0 * frame, &all);
    part_sensor.Measure(part.Render(T_world_camera, kWindow), frame, 40.0 * frame, &cut);
    ASSERT_EQ(cut.width, kWindow.width());
    ASSERT_EQ(cut.height, kWindow.height());
    const auto expected = Cut(all, WholeImage(camera), kWindow, SensorModel::kAlignment);
    EXPECT_EQ(expected, Cut(cut, kWindow, kWindow, SensorModel::kAlignment));
    EXPECT_GT(std::count(expected.begin(), expected.end(), 0U), 500);  // Shadows.
  }
}

TEST(SensorWindow, OfTheImagesCornerIsCutFromTheWholeImageToo) {
  Rng rng(3);
  const CameraModel camera;
  SceneRenderer renderer(Scene(), camera);
  SensorModel sensor({}, camera);
  const Pose T_world_camera = Camera(rng);
  DepthImage all, cut;
  const PixelWindow corner{400, 304, camera.width - 1, camera.height - 1};
  sensor.Measure(renderer.Render(T_world_camera), 0, 0.0, &all);
  sensor.Measure(renderer.Render(T_world_camera, corner), 0, 0.0, &cut);
  constexpr int kMargin = SensorModel::kAlignment;
  for (int v = corner.v0 + kMargin; v < camera.height; ++v) {
    for (int u = corner.u0 + kMargin; u < camera.width; ++u) {
      const float a = all.at(u, v);
      const float b = cut.at(u - corner.u0, v - corner.v0);
      ASSERT_TRUE(a == b || (std::isnan(a) && std::isnan(b))) << u << " " << v;
    }
  }
}

TEST(SensorModel, AnotherDeviceIsOneMadeAnew) {
  Rng rng(4);
  const CameraModel camera;
  SceneRenderer renderer(Scene(), camera);
  const RenderedView& view = renderer.Render(Camera(rng), kWindow);
  SensorModelParameters parameters;
  SensorModel changed(parameters, camera);
  DepthImage before, after, anew;
  changed.Measure(view, 0, 0.0, &before);
  changed.SetDevice(123);
  changed.Measure(view, 0, 0.0, &after);
  parameters.device_id = 123;
  SensorModel(parameters, camera).Measure(view, 0, 0.0, &anew);
  EXPECT_EQ(Cut(after, kWindow, kWindow, 0), Cut(anew, kWindow, kWindow, 0));
  EXPECT_NE(Cut(after, kWindow, kWindow, 0), Cut(before, kWindow, kWindow, 0));
}

TEST(SensorWindowDeathTest, BeginsAtAMultiple) {
  SceneRenderer renderer(Scene(), {});
  SensorModel sensor({}, {});
  DepthImage depth;
  const RenderedView& view = renderer.Render(Pose::Identity(), {8, 0, 99, 99});
  EXPECT_DEATH(sensor.Measure(view, 0, 0.0, &depth), "multiples of 16");
}

TEST(SceneWindowDeathTest, IsWithinTheImage) {
  SceneRenderer renderer(Scene(), {});
  EXPECT_DEATH(renderer.Render(Pose::Identity(), {0, 0, 640, 99}), "within the image");
  EXPECT_DEATH(renderer.Render(Pose::Identity(), {10, 0, 9, 99}), "within the image");
}

}  // namespace
}  // namespace vantage
