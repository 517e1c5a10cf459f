#include "drivers/sim/openni2_plugin.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <utility>

#include "drivers/sim/openni2_property.h"

namespace vantage {
namespace {

using Clock = std::chrono::steady_clock;

constexpr Clock::duration kFramePeriod = std::chrono::nanoseconds(1'000'000'000 / 30);
constexpr std::chrono::milliseconds kFaultInterval{10};
constexpr char kUriPrefix[] = "vantage-sim://";

void CopyText(const std::string& text, char (&out)[ONI_MAX_STR]) {
  std::snprintf(out, sizeof(out), "%s", text.c_str());
}

}  // namespace

SimDevice::SimDevice(const SimDeviceSetup& setup,
                     Clock::time_point plugged_in,
                     std::function<bool()> stalled,
                     std::function<bool()> take_short_frame)
    : setup_(setup),
      plugged_in_(plugged_in),
      stalled_(std::move(stalled)),
      take_short_frame_(std::move(take_short_frame)),
      depth_modes_(SimVideoModes(ONI_SENSOR_DEPTH, setup.camera)),
      color_modes_(SimVideoModes(ONI_SENSOR_COLOR, setup.camera)),
      sensors_{OniSensorInfo{
                   ONI_SENSOR_DEPTH, static_cast<int>(depth_modes_.size()), depth_modes_.data()},
               OniSensorInfo{
                   ONI_SENSOR_COLOR, static_cast<int>(color_modes_.size()), color_modes_.data()}},
      camera_(setup),
      thread_([this](const std::stop_token& stop) { Run(stop); }) {}

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
  streams_.push_back(std::make_shared<SimStream>(sensor, setup_.camera, [this] {
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
  registration_ = mode;
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
  return mode == ONI_IMAGE_REGISTRATION_OFF || mode == ONI_IMAGE_REGISTRATION_DEPTH_TO_COLOR
             ? TRUE
             : FALSE;
}

bool SimDevice::AnyStarted() const {
  return std::any_of(
      streams_.begin(), streams_.end(), [](const auto& stream) { return stream->started(); });
}

void SimDevice::Run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    {
      std::unique_lock lock(mutex_);
      stream_started_.wait(lock, stop, [this] { return AnyStarted(); });
    }
    // Ticks lie on the grid of the device's clock; those that were missed are lost frames.
    const auto index = (Clock::now() - plugged_in_) / kFramePeriod + 1;
    const Clock::time_point tick = plugged_in_ + index * kFramePeriod;
    {
      std::unique_lock lock(mutex_);
      stream_started_.wait_until(lock, stop, tick, [] { return false; });
    }
    if (stop.stop_requested() || stalled_()) continue;
    const std::optional<Pose> T_world_camera = setup_.source->CameraPose();
    // The pose is of now, and so is the exposure.
    if (T_world_camera) TakeImages(*T_world_camera, index, Clock::now() - plugged_in_);
  }
}

void SimDevice::TakeImages(const Pose& T_world_camera, int64_t index, Clock::duration at) {
  const auto timestamp =
      static_cast<uint64_t>(std::chrono::duration_cast<std::chrono::microseconds>(at).count());
  camera_.Expose(T_world_camera, index, std::chrono::duration<double>(at).count());
  const bool is_short = take_short_frame_();
  const auto frame_index = static_cast<int>(index);
  std::vector<std::shared_ptr<SimStream>> streams;
  {
    const std::lock_guard lock(mutex_);
    streams = streams_;
  }
  // Color first: who reads waits for the color image of a depth image half a frame at most, and a
  // board takes longer to paint.
  std::ranges::stable_partition(
      streams, [](const auto& stream) { return stream->sensor() != ONI_SENSOR_DEPTH; });
  // Without the lock: whoever hears of the frame may ask the device for something.
  for (const std::shared_ptr<SimStream>& stream : streams) {
    if (!stream->started()) continue;
    if (stream->sensor() == ONI_SENSOR_DEPTH) {
      const std::vector<uint16_t>& depth = camera_.Depth(stream->width());
      stream->Deliver(depth.data(), 2 * depth.size(), timestamp, frame_index, is_short);
    } else {
      const std::vector<uint8_t>& rgb = camera_.Color(stream->width());
      stream->Deliver(rgb.data(), rgb.size(), timestamp, frame_index, is_short);
    }
  }
}

SimDriver::SimDriver(OniDriverServices* services, SimDeviceFactory make_device)
    : DriverBase(services), make_device_(std::move(make_device)) {}

SimDriver::~SimDriver() { shutdown(); }

OniStatus SimDriver::initialize(oni::driver::DeviceConnectedCallback connected,
                                oni::driver::DeviceDisconnectedCallback disconnected,
                                oni::driver::DeviceStateChangedCallback state_changed,
                                void* cookie) {
  DriverBase::initialize(connected, disconnected, state_changed, cookie);
  Result<std::optional<SimDeviceSetup>> setup = make_device_();
  if (!setup) {
    std::fprintf(stderr, "simulated camera: %s\n", setup.error().message.c_str());
    return ONI_STATUS_OK;  // No device; the other plugins are not to suffer.
  }
  setup_ = std::move(*setup);
  if (!setup_) return ONI_STATUS_OK;
  CopyText(kUriPrefix + setup_->serial, info_.uri);
  CopyText("Vantage", info_.vendor);
  CopyText("Simulated Xtion", info_.name);
  UpdatePlugged();
  watcher_ = std::jthread([this](const std::stop_token& stop) { WatchFaults(stop); });
  return ONI_STATUS_OK;
}

double SimDriver::Now() const {
  return std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
}

void SimDriver::WatchFaults(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    for (const SimFault& fault : setup_->source->TakeFaults()) {
      const std::lock_guard lock(mutex_);
      faults_.Apply(fault, Now());
    }
    UpdatePlugged();
    std::this_thread::sleep_for(kFaultInterval);
  }
}

void SimDriver::UpdatePlugged() {
  bool plugged = false;
  {
    const std::lock_guard lock(mutex_);
    plugged = faults_.Plugged(Now());
    if (plugged == plugged_) return;
    plugged_ = plugged;
    if (plugged) plugged_in_ = Clock::now();
    for (SimDevice* device : open_) device->Unplug();
  }
  // OpenNI2 may call back into this driver from here, so without the lock.
  if (plugged) {
    deviceConnected(&info_);
  } else {
    deviceDisconnected(&info_);
  }
}

oni::driver::DeviceBase* SimDriver::deviceOpen(const char* uri, const char* /*mode*/) {
  const std::lock_guard lock(mutex_);
  if (!plugged_ || std::strcmp(uri, info_.uri) != 0) return nullptr;
  const auto stalled = [this] {
    const std::lock_guard lock_faults(mutex_);
    return faults_.Stalled(Now());
  };
  const auto take_short_frame = [this] {
    const std::lock_guard lock_faults(mutex_);
    return faults_.TakeShortFrame(Now());
  };
  auto device = std::make_unique<SimDevice>(*setup_, plugged_in_, stalled, take_short_frame);
  open_.insert(device.get());
  return device.release();
}

void SimDriver::deviceClose(oni::driver::DeviceBase* device) {
  std::unique_ptr<oni::driver::DeviceBase> closing(device);
  const std::lock_guard lock(mutex_);
  std::erase_if(open_, [device](const SimDevice* each) { return each == device; });
  // The device's thread asks for faults under the lock, so it ends after it.
}

OniStatus SimDriver::tryDevice(const char* uri) {
  const std::lock_guard lock(mutex_);
  return plugged_ && std::strcmp(uri, info_.uri) == 0 ? ONI_STATUS_OK : ONI_STATUS_ERROR;
}

void SimDriver::shutdown() {
  watcher_.request_stop();
  if (watcher_.joinable()) watcher_.join();
}

}  // namespace vantage
