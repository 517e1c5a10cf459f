#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "bus/bus.h"
#include "common/result.h"
#include "drivers/sim/sim_arm.h"
#include "drivers/sim/sim_hand.h"
#include "nodes/config_reader.h"
#include "nodes/node.h"
#include "nodes/process.h"
#include "vantage/next_view_t.hpp"

namespace vantage {

/// The simulated robot on the bus: carries the camera where NEXT_VIEW says, publishes
/// CAMERA_<NAME>_TO_WORLD at 100 Hz and ARM_STATUS at 10 Hz and after every change. It moves by a
/// clock that nobody sets, as a robot does; its messages have the time of the bus.
/// With a hand it knows nothing of a camera: it goes where NEXT_HAND_POSE says and publishes
/// HAND_TO_BASE, its base being the world's origin; the camera's true pose goes to the simulated
/// camera alone, on SIM_CAMERA_<NAME>_TO_WORLD.
class SimArmNode : public Node {
 public:
  /// us since some start; never goes back.
  using SteadyClock = std::function<int64_t()>;

  SimArmNode(Bus& bus,
             const SimArmParameters& parameters,
             const std::optional<SimHandParameters>& hand,
             const std::string& camera_name,
             SteadyClock steady_us);

  /// Errors: the bus refuses the subscription.
  Result<void> Subscribe();

  void Poll() override;
  [[nodiscard]] std::chrono::milliseconds poll_interval() const override {
    return std::chrono::milliseconds(5);
  }

 private:
  void HandleNextView(const next_view_t& view);
  void PublishPoses(int64_t now);
  void PublishStatus(int64_t now);
  [[nodiscard]] double Seconds(int64_t steady_us) const;

  Bus& bus_;
  SimArm arm_;
  const std::optional<SimHand> hand_;
  const std::string camera_name_;
  const std::string pose_channel_;  // Of the camera's true pose.
  const SteadyClock steady_us_;
  const int64_t start_us_;  // Of the steady clock, as the two below.
  int64_t next_pose_us_;
  int64_t next_status_us_;
  int64_t status_seq_ = 0;
  int8_t last_state_ = -1;
  // The last view that was decided on.
  int64_t view_seq_ = -1;
  std::optional<Pose> view_pose_;  // As it was asked for.
  std::string refusal_;            // Why it was refused; empty if it was accepted.
};

/// Reads [sim] and [sim.arm]. Errors: config, bus.
Result<std::unique_ptr<Node>> MakeSimArmNode(Bus& bus,
                                             ConfigReader& config,
                                             const ProcessOptions& options);

}  // namespace vantage
