#pragma once

#include <Driver/OniDriverAPI.h>

#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "common/result.h"
#include "drivers/sim/fault_state.h"
#include "drivers/sim/openni2_sim_device.h"
#include "drivers/sim/sim_camera.h"

namespace vantage {

/// Makes the cameras that a plugin offers, each with a serial of its own.
using SimDeviceFactory = std::function<Result<std::vector<SimDeviceSetup>>()>;

/// The driver that OpenNI2 loads: offers simulated cameras, and unplugs and plugs them on command.
class SimDriver : public oni::driver::DriverBase {
 public:
  SimDriver(OniDriverServices* services, SimDeviceFactory make_devices);
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
  void* enableFrameSync(oni::driver::StreamBase** streams, int count) override;
  void shutdown() override;

 private:
  // A camera that is or was plugged in.
  struct Port {
    SimDeviceSetup setup;
    OniDeviceInfo info{};
    FaultState faults;
    bool plugged = false;
    std::chrono::steady_clock::time_point plugged_in;
  };
  struct Opened {
    SimDevice* device = nullptr;
    Port* port = nullptr;
    int lock = -1;  // Descriptor of what keeps other programs off; -1: nothing does.
  };

  [[nodiscard]] double Now() const;
  void WatchFaults(const std::stop_token& stop);
  void UpdatePlugged(Port& port);
  Port* FindPort(const char* uri);

  SimDeviceFactory make_devices_;
  std::vector<std::unique_ptr<Port>> ports_;
  std::mutex mutex_;  // Guards the ports' states and what follows.
  std::vector<Opened> open_;
  std::jthread watcher_;
};

}  // namespace vantage
