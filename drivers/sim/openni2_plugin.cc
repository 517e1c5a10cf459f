#include "drivers/sim/openni2_plugin.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <utility>

namespace vantage {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kFaultInterval{10};
constexpr char kUriPrefix[] = "vantage-sim://";

void CopyText(const std::string& text, char (&out)[ONI_MAX_STR]) {
  std::snprintf(out, sizeof(out), "%s", text.c_str());
}

// A name that the kernel gives to one program at a time, and takes back when it ends; -1: another
// one has it.
int LockName(const std::string& serial) {
  const std::string text = "vantage-sim/" + serial;
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const size_t length = std::min(text.size(), sizeof(address.sun_path) - 1);
  std::memcpy(address.sun_path + 1, text.data(), length);  // After a NUL: abstract.
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + length);
  const int descriptor = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (descriptor < 0) return -1;
  if (bind(descriptor, reinterpret_cast<const sockaddr*>(&address), size) == 0) return descriptor;
  close(descriptor);
  return -1;
}

}  // namespace

SimDriver::SimDriver(OniDriverServices* services, SimDeviceFactory make_devices)
    : DriverBase(services), make_devices_(std::move(make_devices)) {}

SimDriver::~SimDriver() { shutdown(); }

OniStatus SimDriver::initialize(oni::driver::DeviceConnectedCallback connected,
                                oni::driver::DeviceDisconnectedCallback disconnected,
                                oni::driver::DeviceStateChangedCallback state_changed,
                                void* cookie) {
  DriverBase::initialize(connected, disconnected, state_changed, cookie);
  Result<std::vector<SimDeviceSetup>> setups = make_devices_();
  if (!setups) {
    std::fprintf(stderr, "simulated camera: %s\n", setups.error().message.c_str());
    return ONI_STATUS_OK;  // No device; the other plugins are not to suffer.
  }
  for (SimDeviceSetup& setup : *setups) {
    auto port = std::make_unique<Port>();
    port->setup = std::move(setup);
    CopyText(kUriPrefix + port->setup.serial, port->info.uri);
    CopyText("Vantage", port->info.vendor);
    CopyText("Simulated Xtion", port->info.name);
    ports_.push_back(std::move(port));
  }
  for (const std::unique_ptr<Port>& port : ports_) UpdatePlugged(*port);
  if (ports_.empty()) return ONI_STATUS_OK;
  watcher_ = std::jthread([this](const std::stop_token& stop) { WatchFaults(stop); });
  return ONI_STATUS_OK;
}

double SimDriver::Now() const {
  return std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
}

void SimDriver::WatchFaults(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    for (const std::unique_ptr<Port>& port : ports_) {
      for (const SimFault& fault : port->setup.source->TakeFaults()) {
        const std::lock_guard lock(mutex_);
        port->faults.Apply(fault, Now());
      }
      UpdatePlugged(*port);
    }
    std::this_thread::sleep_for(kFaultInterval);
  }
}

void SimDriver::UpdatePlugged(Port& port) {
  bool plugged = false;
  {
    const std::lock_guard lock(mutex_);
    plugged = port.faults.Plugged(Now());
    if (plugged == port.plugged) return;
    port.plugged = plugged;
    if (plugged) port.plugged_in = Clock::now();
    for (const Opened& opened : open_) {
      if (opened.port == &port) opened.device->Unplug();
    }
  }
  // OpenNI2 may call back into this driver from here, so without the lock.
  if (plugged) {
    deviceConnected(&port.info);
  } else {
    deviceDisconnected(&port.info);
  }
}

SimDriver::Port* SimDriver::FindPort(const char* uri) {
  for (const std::unique_ptr<Port>& port : ports_) {
    if (port->plugged && std::strcmp(uri, port->info.uri) == 0) return port.get();
  }
  return nullptr;
}

oni::driver::DeviceBase* SimDriver::deviceOpen(const char* uri, const char* /*mode*/) {
  Port* port = nullptr;
  Clock::time_point plugged_in;
  {
    const std::lock_guard lock(mutex_);
    port = FindPort(uri);
    if (port == nullptr) return nullptr;
    plugged_in = port->plugged_in;
  }
  const SimAbilities abilities = port->setup.source->Abilities();
  const int name_lock = abilities.exclusive ? LockName(port->setup.serial) : -1;
  if (abilities.exclusive && name_lock < 0) return nullptr;
  std::this_thread::sleep_for(abilities.opening_time);
  const auto take_fault = [this, port](SimFault::Kind kind) {
    const std::lock_guard lock(mutex_);
    return port->faults.TakeFrame(kind, Now());
  };
  auto device = std::make_unique<SimDevice>(port->setup, abilities, plugged_in, take_fault);
  const std::lock_guard lock(mutex_);
  open_.push_back({device.get(), port, name_lock});
  return device.release();
}

void SimDriver::deviceClose(oni::driver::DeviceBase* device) {
  int name_lock = -1;
  {
    const std::lock_guard lock(mutex_);
    std::erase_if(open_, [&](const Opened& opened) {
      if (opened.device != device) return false;
      name_lock = opened.lock;
      return true;
    });
  }
  // Without the lock, under which the device's thread asks for faults.
  delete device;
  if (name_lock >= 0) close(name_lock);
}

OniStatus SimDriver::tryDevice(const char* uri) {
  const std::lock_guard lock(mutex_);
  return FindPort(uri) != nullptr ? ONI_STATUS_OK : ONI_STATUS_ERROR;
}

void* SimDriver::enableFrameSync(oni::driver::StreamBase** /*streams*/, int /*count*/) {
  // All images of a device are taken at once; OpenNI2 wants anything that is not null.
  const std::lock_guard lock(mutex_);
  const bool can = !open_.empty() && open_.back().device->abilities().frame_sync;
  return can ? this : nullptr;
}

void SimDriver::shutdown() {
  watcher_.request_stop();
  if (watcher_.joinable()) watcher_.join();
}

}  // namespace vantage
