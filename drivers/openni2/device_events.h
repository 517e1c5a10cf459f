#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <set>
#include <string>

namespace vantage {

/// What OpenNI2 tells of devices on threads of its drivers, for the thread that uses them. No
/// OpenNI2 call is made from those threads: its locks are held there.
class DeviceEvents {
 public:
  void Connected();
  void Disconnected(const std::string& uri);
  void Ended(const std::string& uri);

  /// Forgets what was told of a device; before it is opened.
  void Forget(const std::string& uri);
  [[nodiscard]] bool IsGone(const std::string& uri);
  [[nodiscard]] bool HasEnded(const std::string& uri);
  /// True at once when a device was connected since the last call, or within `timeout`.
  bool WaitForConnection(std::chrono::milliseconds timeout);

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool connected_ = false;
  std::set<std::string> gone_;
  std::set<std::string> ended_;
};

}  // namespace vantage
