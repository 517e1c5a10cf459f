#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/result.h"
#include "drivers/openni2/depth_device.h"

namespace vantage {

/// DepthDeviceApi through the OpenNI2 library: whatever its drivers find, and its recordings.
class Openni2Api : public DepthDeviceApi {
 public:
  /// Errors: OpenNI2 finds none of its drivers.
  static Result<std::unique_ptr<Openni2Api>> Create();
  ~Openni2Api() override;
  Openni2Api(const Openni2Api&) = delete;
  Openni2Api& operator=(const Openni2Api&) = delete;

  std::vector<DeviceListing> List() override;
  Result<std::unique_ptr<DepthDevice>> Open(const std::string& uri) override;
  bool WaitForDevice(std::chrono::milliseconds timeout) override;
  int64_t MonotonicUs() override;
  int64_t WallUs() override;
  void Sleep(std::chrono::microseconds duration) override;

 private:
  class Listener;
  explicit Openni2Api(std::unique_ptr<Listener> listener);
  std::unique_ptr<Listener> listener_;
};

}  // namespace vantage
