#include "drivers/openni2/device_events.h"

namespace vantage {

void DeviceEvents::Connected() {
  const std::lock_guard lock(mutex_);
  connected_ = true;
  changed_.notify_all();
}

void DeviceEvents::Disconnected(const std::string& uri) {
  const std::lock_guard lock(mutex_);
  gone_.insert(uri);
}

void DeviceEvents::Ended(const std::string& uri) {
  const std::lock_guard lock(mutex_);
  ended_.insert(uri);
}

void DeviceEvents::Forget(const std::string& uri) {
  const std::lock_guard lock(mutex_);
  gone_.erase(uri);
  ended_.erase(uri);
}

bool DeviceEvents::IsGone(const std::string& uri) {
  const std::lock_guard lock(mutex_);
  return gone_.contains(uri);
}

bool DeviceEvents::HasEnded(const std::string& uri) {
  const std::lock_guard lock(mutex_);
  return ended_.contains(uri);
}

bool DeviceEvents::WaitForConnection(std::chrono::milliseconds timeout) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, timeout, [this] { return connected_; });
  const bool connected = connected_;
  connected_ = false;
  return connected;
}

}  // namespace vantage
