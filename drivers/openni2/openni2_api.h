#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/result.h"
#include "drivers/camera/camera_device.h"

namespace vantage {

/// CameraDeviceApi through the OpenNI2 library: whatever its drivers find, and its recordings.
class Openni2Api : public CameraDeviceApi {
 public:
  /// Errors: OpenNI2 finds none of its drivers.
  static Result<std::unique_ptr<Openni2Api>> Create();
  ~Openni2Api() override;
  Openni2Api(const Openni2Api&) = delete;
  Openni2Api& operator=(const Openni2Api&) = delete;

  [[nodiscard]] std::string name() const override { return "OpenNI2"; }
  [[nodiscard]] std::string search_hint() const override {
    return "check the cable, `lsusb`, and udev rules";
  }
  std::vector<DeviceListing> List() override;
  Result<std::unique_ptr<CameraDevice>> Open(const std::string& uri) override;
  bool WaitForDevice(std::chrono::milliseconds timeout) override;

 private:
  class Listener;
  explicit Openni2Api(std::unique_ptr<Listener> listener);
  std::unique_ptr<Listener> listener_;
};

}  // namespace vantage
