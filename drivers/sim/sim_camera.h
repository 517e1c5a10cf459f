#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/camera_model.h"
#include "common/so3.h"
#include "drivers/sim/board_painter.h"
#include "drivers/sim/fault_state.h"
#include "drivers/sim/openni2_abilities.h"
#include "drivers/sim/scene.h"
#include "drivers/sim/sensor_model.h"

namespace vantage {

/// Where a simulated camera learns how it is placed and what shall go wrong. Called from the
/// threads of the plugin, several at a time.
class SimDeviceSource {
 public:
  virtual ~SimDeviceSource() = default;
  /// T_world_camera now; nothing until one is known.
  virtual std::optional<Pose> CameraPose() = 0;
  /// Faults that came since the last call, oldest first.
  virtual std::vector<SimFault> TakeFaults() = 0;
  /// What the device can do; asked whenever it is opened.
  virtual SimAbilities Abilities() { return {}; }
};

/// One simulated camera.
struct SimDeviceSetup {
  std::string serial = "SIM0001";
  CameraModel camera;  ///< At full resolution; half of it is offered too.
  SimScene scene;
  SensorModelParameters sensor;
  std::unique_ptr<SimDeviceSource> source;
};

/// Takes the images of one camera at one place and time, each rendered once however many streams
/// want it. Not thread-safe.
class SimCamera {
 public:
  /// `setup` must outlive this.
  explicit SimCamera(const SimDeviceSetup& setup) : setup_(setup) {}

  /// Starts an exposure: what follows is of this pose, frame number and time (s, device's).
  void Expose(const Pose& T_world_camera, int64_t frame, double time);
  /// Depth in mm, 0 = none, at a width in px of the full or the half resolution.
  const std::vector<uint16_t>& Depth(int width);
  /// RGB888.
  const std::vector<uint8_t>& Color(int width);

 private:
  struct Resolution {
    std::unique_ptr<SceneRenderer> renderer;
    std::unique_ptr<SensorModel> sensor;
    const RenderedView* view = nullptr;  // Of this exposure.
    DepthImage measured;
    std::vector<uint16_t> millimetres;
    std::vector<uint8_t> rgb;
  };
  Resolution& Rendered(int width);

  const SimDeviceSetup& setup_;
  std::unique_ptr<BoardPainter> painter_;  // From the first color image of a scene with a board on.
  std::map<int, Resolution> resolutions_;  // By width.
  Pose T_world_camera_ = Pose::Identity();
  int64_t frame_ = 0;
  double time_ = 0.0;
};

}  // namespace vantage
