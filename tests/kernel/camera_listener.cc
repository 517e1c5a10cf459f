#include "tests/kernel/camera_listener.h"

#include <stdexcept>

#include "bus/image_conversion.h"
#include "common/format.h"
#include "vantage/camera_command_v2_t.hpp"

namespace vantage {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kPatience(10);

void Demand(const Result<void>& result) {
  if (!result) throw std::runtime_error(result.error().message);
}

camera_command_v2_t NoChange() {
  camera_command_v2_t command{};
  command.exposure_us = -1;
  command.gain = -1;
  return command;
}

}  // namespace

CameraListener::CameraListener(const std::string& camera) : channel_("CAMERA_" + camera) {
  status_.state = -1;
  LiveBus::Options options;
  options.name = "kernel-test-" + camera;
  Result<std::unique_ptr<LiveBus>> bus = LiveBus::Create(options);
  if (!bus) throw std::runtime_error(bus.error().message);
  bus_ = std::move(bus).value();
  Demand(bus_->Subscribe<images_t>(
      channel_, {}, [this](const Envelope& envelope, const images_t& message) {
        const int64_t seq = message.images.empty() ? -1 : ImageSeq(message.images[0]);
        arrivals_.push_back({seq, message.utime, envelope.receive_utime});
        images_ = message;
      }));
  Demand(bus_->Subscribe<camera_status_v2_t>(
      channel_ + "_STATUS", {}, [this](const Envelope&, const camera_status_v2_t& message) {
        status_ = message;
      }));
}

bool CameraListener::ListenUntil(const std::function<bool()>& condition) {
  const Clock::time_point give_up = Clock::now() + kPatience;
  while (!condition()) {
    if (Clock::now() > give_up) return false;
    bus_->Dispatch(std::chrono::milliseconds(50));
  }
  return true;
}

void CameraListener::ListenFor(std::chrono::milliseconds duration) {
  const Clock::time_point end = Clock::now() + duration;
  while (Clock::now() < end) bus_->Dispatch(std::chrono::milliseconds(10));
}

bool CameraListener::ListenForImages(size_t count) {
  const size_t wanted = arrivals_.size() + count;
  return ListenUntil([&] { return arrivals_.size() >= wanted; });
}

bool CameraListener::ListenForState(int8_t state) {
  return ListenUntil([&] { return status_.state == state; });
}

bool CameraListener::ListenForMessage(const std::string& text) {
  return ListenUntil([&] { return status_.message.find(text) != std::string::npos; });
}

void CameraListener::SendControl(const std::string& name, int64_t value) {
  camera_command_v2_t command = NoChange();
  command.num_controls = 1;
  command.control_names = {name};
  command.control_values = {value};
  Demand(bus_->Publish(channel_ + "_COMMAND", command));
}

void CameraListener::SendRestart() {
  camera_command_v2_t command = NoChange();
  command.restart = true;
  Demand(bus_->Publish(channel_ + "_COMMAND", command));
}

int64_t CameraListener::NumLost() const {
  if (arrivals_.empty()) return 0;
  const int64_t span = arrivals_.back().seq - arrivals_.front().seq + 1;
  return span - static_cast<int64_t>(arrivals_.size());
}

std::string CameraListener::Summary() const {
  return Format(
      "%zu images, %jd lost; state %d, \"%s\", captured %jd, published %jd, dropped %jd, bad %jd, "
      "missed %jd, reconnects %jd",
      arrivals_.size(),
      intmax_t{NumLost()},
      status_.state,
      status_.message.c_str(),
      intmax_t{status_.num_captured},
      intmax_t{status_.num_published},
      intmax_t{status_.num_dropped},
      intmax_t{status_.num_bad},
      intmax_t{status_.num_missed},
      intmax_t{status_.num_reconnects});
}

}  // namespace vantage
