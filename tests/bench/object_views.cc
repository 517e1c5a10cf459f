#include "tests/bench/object_views.h"

#include <algorithm>

#include "common/depth_rasterizer.h"
#include "common/rng.h"
#include "drivers/sim/scene_renderer.h"
#include "drivers/sim/sensor_model.h"
#include "tools/support/hash.h"

namespace vantage {
namespace {

enum Stream : uint64_t { kPose = 1, kNoise, kDevice };

// Of samples on the surface those that lie on the drawn depth.
double VisibleShare(const ObjectModel& model, const RenderedView& view, const Pose& T) {
  constexpr double kTolerance = 0.01;  // Of the diameter.
  size_t visible = 0;
  for (const SurfacePoint& sample : model.samples) {
    const Eigen::Vector3d p = T * sample.position.cast<double>();
    const Eigen::Vector2d pixel = view.camera.Project(p);
    const auto u = static_cast<int>(std::lround(pixel.x()));
    const auto v = static_cast<int>(std::lround(pixel.y()));
    if (!view.depth.Contains(u, v)) continue;
    const auto depth = static_cast<double>(view.depth.at(u, v));
    if (depth > p.z() - kTolerance * model.diameter) ++visible;
  }
  return static_cast<double>(visible) / static_cast<double>(model.samples.size());
}

}  // namespace

std::vector<ObjectView> MakeObjectViews(const ObjectModel& model, int count, uint64_t seed) {
  constexpr double kLargest = 0.2;  // m, of which the distances hold.
  const double scale = std::max(1.0, model.diameter / kLargest);
  SimScene scene;
  scene.objects.push_back({model.id, model.mesh, Pose::Identity()});
  const CameraModel camera;
  SceneRenderer renderer(scene, camera);
  std::vector<ObjectView> views;
  for (int i = 0; i < count; ++i) {
    const uint64_t view_seed = MixBits(seed * 1000003U + static_cast<uint64_t>(i));
    Rng rng(view_seed, kPose);
    Pose T_camera_object(rng.Rotation());
    const double distance = scale * rng.Uniform(0.6, 0.9);
    const Eigen::Vector3d center(
        scale * rng.Uniform(-0.03, 0.03), scale * rng.Uniform(-0.03, 0.03), distance);
    T_camera_object.translation() = center - T_camera_object.linear() * model.center;
    const RenderedView& ideal = renderer.Render(T_camera_object.inverse());
    SensorModelParameters device;
    device.seed = MixBits(view_seed + kNoise);
    device.device_id = MixBits(view_seed + kDevice);
    SensorModel sensor(device, camera);
    ObjectView view;
    view.camera = camera;
    view.T_camera_object = T_camera_object;
    view.visible_share = VisibleShare(model, ideal, T_camera_object);
    sensor.Measure(ideal, i, 0.0, &view.depth);
    views.push_back(std::move(view));
  }
  return views;
}

}  // namespace vantage
