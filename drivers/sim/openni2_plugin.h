#pragma once

#include <Driver/OniDriverAPI.h>

#include <array>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "common/result.h"
#include "drivers/sim/fault_state.h"
#include "drivers/sim/openni2_stream.h"
#include "drivers/sim/sim_camera.h"

namespace vantage {

/// Makes the camera that a plugin offers; nothing when there is none to offer.
using SimDeviceFactory = std::function<Result<std::optional<SimDeviceSetup>>()>;

/// One opening of the simulated camera. While a stream is started a thread of its own takes images
/// at 30 fps; who reads too slowly misses frames.
class SimDevice : public oni::driver::DeviceBase {
 public:
  /// `setup` must outlive this. `plugged_in`: start of the device's clock.
  SimDevice(const SimDeviceSetup& setup,
            std::chrono::steady_clock::time_point plugged_in,
            std::function<bool()> stalled,
            std::function<bool()> take_short_frame);
  ~SimDevice() override;
  SimDevice(const SimDevice&) = delete;
  SimDevice& operator=(const SimDevice&) = delete;

  OniStatus getSensorInfoList(OniSensorInfo** sensors, int* count) override;
  oni::driver::StreamBase* createStream(OniSensorType sensor) override;
  void destroyStream(oni::driver::StreamBase* stream) override;
  OniStatus getProperty(int property, void* data, int* size) override;
  OniStatus setProperty(int property, const void* data, int size) override;
  OniBool isPropertySupported(int property) override;
  OniBool isImageRegistrationModeSupported(OniImageRegistrationMode mode) override;

  /// The device is gone: no more frames, for good.
  void Unplug() { thread_.request_stop(); }

 private:
  void Run(const std::stop_token& stop);
  [[nodiscard]] bool AnyStarted() const;
  void TakeImages(const Pose& T_world_camera,
                  int64_t index,
                  std::chrono::steady_clock::duration at);

  const SimDeviceSetup& setup_;
  const std::chrono::steady_clock::time_point plugged_in_;
  const std::function<bool()> stalled_;
  const std::function<bool()> take_short_frame_;
  std::array<OniVideoMode, 2> depth_modes_;
  std::array<OniVideoMode, 2> color_modes_;
  std::array<OniSensorInfo, 2> sensors_;
  SimCamera camera_;  // Of the thread.
  std::mutex mutex_;  // Guards streams_ and registration_.
  std::condition_variable_any stream_started_;
  std::vector<std::shared_ptr<SimStream>> streams_;  // Shared with an image under way.
  OniImageRegistrationMode registration_ = ONI_IMAGE_REGISTRATION_OFF;
  std::jthread thread_;
};

/// The driver that OpenNI2 loads: offers one simulated camera, and unplugs and plugs it on command.
class SimDriver : public oni::driver::DriverBase {
 public:
  SimDriver(OniDriverServices* services, SimDeviceFactory make_device);
  ~SimDriver() override;
  SimDriver(const SimDriver&) = delete;
  SimDriver& operator=(const SimDriver&) = delete;

  OniStatus initialize(oni::driver::DeviceConnectedCallback connected,
                       oni::driver::DeviceDisconnectedCallback disconnected,
                       oni::driver::DeviceStateChangedCallback state_changed,
                       void* cookie) override;
  oni::driver::DeviceBase* deviceOpen(const char* uri, const char* mode) override;
  void deviceClose(oni::driver::DeviceBase* device) override;
  OniStatus tryDevice(const char* uri) override;
  void shutdown() override;

 private:
  [[nodiscard]] double Now() const;
  void WatchFaults(const std::stop_token& stop);
  void UpdatePlugged();

  SimDeviceFactory make_device_;
  std::optional<SimDeviceSetup> setup_;
  OniDeviceInfo info_{};
  std::mutex mutex_;  // Guards what follows.
  FaultState faults_;
  bool plugged_ = false;
  std::chrono::steady_clock::time_point plugged_in_;
  std::set<SimDevice*> open_;
  std::jthread watcher_;
};

}  // namespace vantage
