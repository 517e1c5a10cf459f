#include "nodes/sim_openni2_module/bus_source.h"

#include <csignal>
#include <future>
#include <utility>

#include "bus/conversions.h"
#include "vantage/rigid_transform_t.hpp"
#include "vantage/sim_command_t.hpp"

namespace vantage {
namespace {

std::optional<SimFault::Kind> FaultKind(int8_t fault) {
  switch (fault) {
    case sim_command_t::UNPLUG:
      return SimFault::Kind::kUnplug;
    case sim_command_t::REPLUG:
      return SimFault::Kind::kReplug;
    case sim_command_t::STALL:
      return SimFault::Kind::kStall;
    case sim_command_t::SHORT_FRAME:
      return SimFault::Kind::kShortFrame;
    default:
      return std::nullopt;
  }
}

/// Signals belong to the program that loaded the plugin; threads inherit the mask.
void LeaveSignalsToTheProgram() {
  sigset_t all;
  sigfillset(&all);
  pthread_sigmask(SIG_BLOCK, &all, nullptr);
}

}  // namespace

Result<std::unique_ptr<BusSource>> BusSource::Create(const LiveBus::Options& options,
                                                     const std::string& pose_channel,
                                                     const std::string& serial) {
  std::unique_ptr<BusSource> source(new BusSource());
  std::promise<Result<void>> started;
  std::future<Result<void>> outcome = started.get_future();
  // A bus is driven by the thread that made it.
  source->thread_ = std::jthread(
      [self = source.get(), options, pose_channel, serial, started = std::move(started)](
          const std::stop_token& stop) mutable {
        LeaveSignalsToTheProgram();
        Result<std::unique_ptr<LiveBus>> bus = LiveBus::Create(options);
        Result<void> ready = bus ? self->Subscribe(**bus, pose_channel, serial) : bus.error();
        const bool run = ready.ok();
        started.set_value(std::move(ready));
        if (run) (*bus)->Run(stop);
      });
  if (Result<void> ready = outcome.get(); !ready) return ready.error();
  return source;
}

Result<void> BusSource::Subscribe(Bus& bus,
                                  const std::string& pose_channel,
                                  const std::string& serial) {
  Result<void> subscribed =
      bus.Subscribe<rigid_transform_t>(pose_channel,
                                       {.keep = SubscribeOptions::Keep::kLatest},
                                       [this](const Envelope&, const rigid_transform_t& message) {
                                         const Result<Pose> pose = PoseFromMessage(message);
                                         if (!pose) return;
                                         const std::lock_guard lock(mutex_);
                                         T_world_camera_ = *pose;
                                       });
  if (!subscribed) return subscribed;
  return bus.Subscribe<sim_command_t>(
      "SIM_COMMAND", {}, [this, serial](const Envelope&, const sim_command_t& command) {
        const std::optional<SimFault::Kind> kind = FaultKind(command.fault);
        if (command.serial != serial || !kind) return;
        const std::lock_guard lock(mutex_);
        faults_.push_back({*kind, command.duration});
      });
}

std::optional<Pose> BusSource::CameraPose() {
  const std::lock_guard lock(mutex_);
  return T_world_camera_;
}

std::vector<SimFault> BusSource::TakeFaults() {
  const std::lock_guard lock(mutex_);
  return std::exchange(faults_, {});
}

}  // namespace vantage
