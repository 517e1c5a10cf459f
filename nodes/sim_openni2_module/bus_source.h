#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "bus/live_bus.h"
#include "common/result.h"
#include "drivers/sim/sim_camera.h"

namespace vantage {

/// The simulated camera's pose and its faults (SIM_COMMAND), received on a thread of its own.
class BusSource : public SimDeviceSource {
 public:
  /// @param pose_channel SimCameraPoseChannel(). @param serial of the device: commands for others
  /// are left alone. Errors: as LiveBus::Create.
  static Result<std::unique_ptr<BusSource>> Create(const LiveBus::Options& options,
                                                   const std::string& pose_channel,
                                                   const std::string& serial);

  std::optional<Pose> CameraPose() override;
  std::vector<SimFault> TakeFaults() override;

 private:
  Result<void> Subscribe(Bus& bus, const std::string& pose_channel, const std::string& serial);

  std::mutex mutex_;  // Guards what follows.
  std::optional<Pose> T_world_camera_;
  std::vector<SimFault> faults_;
  std::jthread thread_;  // Last: it ends before what it writes to.
};

}  // namespace vantage
