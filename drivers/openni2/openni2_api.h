#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/result.h"
#include "drivers/camera/camera_device.h"
#include "drivers/openni2/oni_recording.h"

namespace vantage {

/// CameraDeviceApi through the OpenNI2 library: whatever its drivers find, and its recordings.
class Openni2Api : public CameraDeviceApi {
 public:
  /// @param record where opened devices, but no recordings, are recorded.
  /// Errors: OpenNI2 finds none of its drivers; what `record` says can't be done.
  static Result<std::unique_ptr<Openni2Api>> Create(RecordTarget record = {});
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

  /// The devices with all that they can do, for people. Opens each for a moment, so that one that
  /// another program uses tells its name only.
  std::string Describe();

 private:
  class Listener;
  Openni2Api(std::unique_ptr<Listener> listener, RecordTarget record);
  std::unique_ptr<Listener> listener_;
  RecordTarget record_;
};

}  // namespace vantage
