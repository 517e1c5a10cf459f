#include "drivers/sim/openni2_sim_device.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "drivers/sim/openni2_property.h"

namespace vantage {
namespace {

using Kind = SimFault::Kind;

constexpr std::chrono::steady_clock::duration kFramePeriod =
    std::chrono::nanoseconds(1'000'000'000 / 30);
constexpr uint64_t kColorOffset = 1'000'000;  // us
constexpr uint64_t kStampBack = 5'000'000;    // us

OniSensorInfo SensorOf(OniSensorType type, std::vector<OniVideoMode>& modes) {
  return {type, static_cast<int>(modes.size()), modes.data()};
}

}  // namespace

SimDevice::SimDevice(const SimDeviceSetup& setup,
                     const SimAbilities& abilities,
                     Clock::time_point plugged_in,
                     std::function<bool(SimFault::Kind)> take_fault)
    : setup_(setup),
      abilities_(abilities),
      plugged_in_(plugged_in),
      take_fault_(std::move(take_fault)),
      depth_modes_(SimVideoModes(ONI_SENSOR_DEPTH, setup.camera, abilities)),
      color_modes_(SimVideoModes(ONI_SENSOR_COLOR, setup.camera, abilities)),
      infrared_modes_(SimVideoModes(ONI_SENSOR_IR, setup.camera, abilities)),
      sensors_{SensorOf(ONI_SENSOR_DEPTH, depth_modes_), SensorOf(ONI_SENSOR_COLOR, color_modes_)},
      camera_(setup) {
  if (abilities.infrared) sensors_.push_back(SensorOf(ONI_SENSOR_IR, infrared_modes_));
  thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
}

SimDevice::~SimDevice() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
}

OniStatus SimDevice::getSensorInfoList(OniSensorInfo** sensors, int* count) {
  *sensors = sensors_.data();
  *count = static_cast<int>(sensors_.size());
  return ONI_STATUS_OK;
}

oni::driver::StreamBase* SimDevice::createStream(OniSensorType sensor) {
  if (sensor != ONI_SENSOR_DEPTH && sensor != ONI_SENSOR_COLOR) return nullptr;
  const std::lock_guard lock(mutex_);
  streams_.push_back(std::make_shared<SimStream>(sensor, setup_.camera, abilities_, [this] {
    const std::lock_guard wake(mutex_);
    stream_started_.notify_all();
  }));
  return streams_.back().get();
}

void SimDevice::destroyStream(oni::driver::StreamBase* stream) {
  stream->stop();
  const std::lock_guard lock(mutex_);
  std::erase_if(streams_, [stream](const auto& each) { return each.get() == stream; });
}

OniStatus SimDevice::getProperty(int property, void* data, int* size) {
  const std::lock_guard lock(mutex_);
  switch (property) {
    case ONI_DEVICE_PROPERTY_SERIAL_NUMBER: {
      const auto room = static_cast<int>(setup_.serial.size()) + 1;
      if (data == nullptr || size == nullptr || *size < room) return ONI_STATUS_BAD_PARAMETER;
      std::memcpy(data, setup_.serial.c_str(), static_cast<size_t>(room));
      *size = room;
      return ONI_STATUS_OK;
    }
    case ONI_DEVICE_PROPERTY_DRIVER_VERSION:
      return PutProperty(OniVersion{0, 1, 0, 0}, data, size);
    case ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION:
      return PutProperty(registration_, data, size);
    default:
      return ONI_STATUS_NOT_SUPPORTED;
  }
}

OniStatus SimDevice::setProperty(int property, const void* data, int size) {
  if (property != ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION) return ONI_STATUS_NOT_SUPPORTED;
  OniImageRegistrationMode mode = ONI_IMAGE_REGISTRATION_OFF;
  if (!TakeProperty(data, size, &mode) || isImageRegistrationModeSupported(mode) == FALSE) {
    return ONI_STATUS_BAD_PARAMETER;
  }
  const std::lock_guard lock(mutex_);
  if (abilities_.registration == SimAbilities::Registration::kWorks) registration_ = mode;
  return ONI_STATUS_OK;
}

OniBool SimDevice::isPropertySupported(int property) {
  return property == ONI_DEVICE_PROPERTY_SERIAL_NUMBER ||
                 property == ONI_DEVICE_PROPERTY_DRIVER_VERSION ||
                 property == ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION
             ? TRUE
             : FALSE;
}

OniBool SimDevice::isImageRegistrationModeSupported(OniImageRegistrationMode mode) {
  // Both images are taken from one place: registered either way.
  return mode == ONI_IMAGE_REGISTRATION_OFF ||
                 (mode == ONI_IMAGE_REGISTRATION_DEPTH_TO_COLOR &&
                  abilities_.registration != SimAbilities::Registration::kNone)
             ? TRUE
             : FALSE;
}

bool SimDevice::AnyStarted() const {
  return std::any_of(
      streams_.begin(), streams_.end(), [](const auto& stream) { return stream->started(); });
}

void SimDevice::WaitUntil(Clock::time_point time, const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  stream_started_.wait_until(lock, stop, time, [] { return false; });
}

void SimDevice::Run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    {
      std::unique_lock lock(mutex_);
      stream_started_.wait(lock, stop, [this] { return AnyStarted(); });
    }
    // Ticks lie on the grid of the device's clock; those that were missed are lost frames.
    const auto index = (Clock::now() - plugged_in_) / kFramePeriod + 1;
    WaitUntil(plugged_in_ + index * kFramePeriod, stop);
    if (stop.stop_requested() || take_fault_(Kind::kStall)) continue;
    const std::optional<Pose> T_world_camera = setup_.source->CameraPose();
    if (T_world_camera) TakeImages(*T_world_camera, index, stop);
  }
}

uint64_t SimDevice::Stamp(Clock::time_point time, bool is_early) const {
  const auto stamp = static_cast<uint64_t>(
      std::chrono::duration_cast<std::chrono::microseconds>(time - plugged_in_).count());
  return is_early ? stamp - std::min(stamp, kStampBack) : stamp;
}

void SimDevice::TakeImages(const Pose& T_world_camera, int64_t index, const std::stop_token& stop) {
  // The pose is of now, and so is the exposure.
  const Clock::time_point now = Clock::now();
  camera_.Expose(T_world_camera, index, std::chrono::duration<double>(now - plugged_in_).count());
  frame_index_ = static_cast<int>(index);
  const SimFrameFaults faults{.is_short = take_fault_(Kind::kShortFrame),
                              .has_no_data = take_fault_(Kind::kNoData),
                              .is_resized = take_fault_(Kind::kResized),
                              .is_absurd = take_fault_(Kind::kAbsurdSize)};
  const bool is_early = take_fault_(Kind::kStampBack);
  const Clock::duration color_delay =
      take_fault_(Kind::kColorLate) ? kFramePeriod / 2 : Clock::duration(abilities_.color_delay);
  const bool color_late = color_delay > Clock::duration::zero();
  const bool no_color =
      take_fault_(Kind::kColorStop) || (take_fault_(Kind::kColorHalfRate) && index % 2 != 0);
  std::vector<std::shared_ptr<SimStream>> streams;
  {
    const std::lock_guard lock(mutex_);
    streams = streams_;
  }
  // Color first: who reads waits for the color image of a depth image half a frame at most, and a
  // board takes longer to paint.
  std::ranges::stable_partition(streams, [color_late](const auto& stream) {
    return (stream->sensor() == ONI_SENSOR_DEPTH) == color_late;
  });
  // Without the lock: whoever hears of the frame may ask the device for something.
  for (const std::shared_ptr<SimStream>& stream : streams) {
    if (!stream->started()) continue;
    if (stream->sensor() == ONI_SENSOR_DEPTH) {
      DeliverDepth(*stream, Stamp(now, is_early), faults);
    } else if (!no_color) {
      const Clock::time_point taken = now + color_delay;
      if (color_late) WaitUntil(taken, stop);
      const uint64_t offset = take_fault_(Kind::kColorOffset) ? kColorOffset : 0;
      DeliverColor(*stream, Stamp(taken, is_early) + offset, faults);
    }
  }
}

void SimDevice::DeliverDepth(SimStream& stream, uint64_t timestamp, const SimFrameFaults& faults) {
  const std::vector<uint16_t>* depth = &camera_.Depth(stream.width());
  if (abilities_.fine_depth) {
    tenths_.resize(depth->size());
    // 6.5 m is the furthest that 16 bits hold.
    std::ranges::transform(*depth, tenths_.begin(), [](uint16_t z) {
      return z > UINT16_MAX / 10 ? uint16_t{0} : static_cast<uint16_t>(10 * z);
    });
    depth = &tenths_;
  }
  stream.Deliver(depth->data(), 2 * depth->size(), timestamp, frame_index_, faults);
}

void SimDevice::DeliverColor(SimStream& stream, uint64_t timestamp, const SimFrameFaults& faults) {
  const std::vector<uint8_t>* pixels = &camera_.Color(stream.width());
  if (abilities_.gray_color) {
    gray_.resize(pixels->size() / 3);
    for (size_t i = 0; i < gray_.size(); ++i) gray_[i] = (*pixels)[3 * i + 1];
    pixels = &gray_;
  }
  stream.Deliver(pixels->data(), pixels->size(), timestamp, frame_index_, faults);
}

}  // namespace vantage
