#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "common/result.h"

namespace vantage {

/// Keeps others from opening a device while this one looks what it is. OpenNI2 tells a device's
/// serial only when it is open, and a device opens for one program at a time: of two programs that
/// look for different serials each would find the other's device busy. Programs see each other in
/// one network namespace, and a killed one leaves nothing behind.
class DeviceLock {
 public:
  /// Waits while another program, or another object of this one, holds it. Errors: still held after
  /// `timeout`.
  static Result<std::unique_ptr<DeviceLock>> Acquire(const std::string& uri,
                                                     std::chrono::milliseconds timeout);
  ~DeviceLock();
  DeviceLock(const DeviceLock&) = delete;
  DeviceLock& operator=(const DeviceLock&) = delete;

 private:
  explicit DeviceLock(int descriptor) : descriptor_(descriptor) {}

  int descriptor_;  // -1: the system refuses such locks, and we do without.
};

}  // namespace vantage
