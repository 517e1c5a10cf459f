#pragma once

#include <Driver/OniDriverAPI.h>

#include <array>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <stop_token>
#include <thread>
#include <vector>

#include "drivers/sim/openni2_abilities.h"
#include "drivers/sim/openni2_stream.h"
#include "drivers/sim/sim_camera.h"

namespace vantage {

/// One opening of the simulated camera. While a stream is started a thread of its own takes images
/// at 30 fps; who reads too slowly misses frames.
class SimDevice : public oni::driver::DeviceBase {
 public:
  /// `setup` must outlive this. `plugged_in`: start of the device's clock. `take_fault` tells
  /// whether the frame in hand shall have a fault.
  SimDevice(const SimDeviceSetup& setup,
            const SimAbilities& abilities,
            std::chrono::steady_clock::time_point plugged_in,
            std::function<bool(SimFault::Kind)> take_fault);
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
  [[nodiscard]] const SimAbilities& abilities() const { return abilities_; }

 private:
  using Clock = std::chrono::steady_clock;

  void Run(const std::stop_token& stop);
  void WaitUntil(Clock::time_point time, const std::stop_token& stop);
  [[nodiscard]] bool AnyStarted() const;
  void TakeImages(const Pose& T_world_camera, int64_t index, const std::stop_token& stop);
  void DeliverDepth(SimStream& stream, uint64_t timestamp, const SimFrameFaults& faults);
  void DeliverColor(SimStream& stream, uint64_t timestamp, const SimFrameFaults& faults);
  [[nodiscard]] uint64_t Stamp(Clock::time_point time, bool is_early) const;

  const SimDeviceSetup& setup_;
  const SimAbilities abilities_;
  const Clock::time_point plugged_in_;
  const std::function<bool(SimFault::Kind)> take_fault_;
  std::vector<OniVideoMode> depth_modes_;
  std::vector<OniVideoMode> color_modes_;
  std::vector<OniVideoMode> infrared_modes_;
  std::vector<OniSensorInfo> sensors_;
  SimCamera camera_;  // Of the thread, as what follows.
  int frame_index_ = 0;
  std::vector<uint16_t> tenths_;  // Depth in 0.1 mm.
  std::vector<uint8_t> gray_;
  std::mutex mutex_;  // Guards streams_ and registration_.
  std::condition_variable_any stream_started_;
  std::vector<std::shared_ptr<SimStream>> streams_;  // Shared with an image under way.
  OniImageRegistrationMode registration_ = ONI_IMAGE_REGISTRATION_OFF;
  std::jthread thread_;
};

}  // namespace vantage
