#include "drivers/sim/sim_camera.h"

#include "common/depth_image.h"
#include "drivers/sim/shading.h"

namespace vantage {

void SimCamera::Expose(const Pose& T_world_camera, int64_t frame, double time) {
  T_world_camera_ = T_world_camera;
  frame_ = frame;
  time_ = time;
  for (auto& [width, resolution] : resolutions_) resolution.view = nullptr;
}

SimCamera::Resolution& SimCamera::Rendered(int width) {
  Resolution& resolution = resolutions_[width];
  if (resolution.renderer == nullptr) {
    const CameraModel camera =
        setup_.camera.Scaled(static_cast<double>(width) / setup_.camera.width);
    resolution.renderer = std::make_unique<SceneRenderer>(setup_.scene, camera);
    resolution.sensor = std::make_unique<SensorModel>(setup_.sensor, camera);
  }
  if (resolution.view == nullptr) resolution.view = &resolution.renderer->Render(T_world_camera_);
  return resolution;
}

const std::vector<uint16_t>& SimCamera::Depth(int width) {
  Resolution& resolution = Rendered(width);
  resolution.sensor->Measure(*resolution.view, frame_, time_, &resolution.measured);
  resolution.millimetres.resize(resolution.measured.depth.size());
  for (size_t i = 0; i < resolution.millimetres.size(); ++i) {
    const float z = resolution.measured.depth[i];
    // The sensor's range keeps it below 65.5 m; NaN compares false.
    resolution.millimetres[i] = z > 0.0F && z < 65.5F ? static_cast<uint16_t>(1e3F * z + 0.5F) : 0;
  }
  return resolution.millimetres;
}

const std::vector<uint8_t>& SimCamera::Color(int width) {
  Resolution& resolution = Rendered(width);
  ShadeColor(*resolution.view, &resolution.rgb);
  if (setup_.scene.board) {
    if (painter_ == nullptr) {
      painter_ = std::make_unique<BoardPainter>(*setup_.scene.board,
                                                setup_.sensor.seed ^ setup_.sensor.device_id);
    }
    painter_->Paint(
        *resolution.view, T_world_camera_, resolution.renderer->Board(), frame_, &resolution.rgb);
  }
  return resolution.rgb;
}

}  // namespace vantage
