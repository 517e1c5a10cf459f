#pragma once

#include <OpenNI.h>

#include <memory>
#include <optional>
#include <string>

#include "drivers/camera/camera_device.h"
#include "drivers/openni2/device_events.h"

namespace vantage {

/// CameraDevice through the OpenNI2 library.
class Openni2Device : public CameraDevice {
 public:
  /// `events` outlives the device. Errors: OpenNI2's own, with its words.
  static Result<std::unique_ptr<CameraDevice>> Open(const std::string& uri, DeviceEvents& events);
  ~Openni2Device() override;

  /// A recording was closed: its handles stay with the library, which must not be shut down then.
  static bool HasLeftRecordings();
  Openni2Device(const Openni2Device&) = delete;
  Openni2Device& operator=(const Openni2Device&) = delete;

  [[nodiscard]] std::string serial() const override;
  Result<StreamDetails> Start(const StreamRequest& request) override;
  ReadResult Read(std::chrono::milliseconds timeout, RawFrame* frame) override;
  Result<void> SetExposure(int exposure_us) override;
  Result<void> SetGain(int gain) override;
  Result<void> SetControl(const std::string& name, int64_t value) override;

 private:
  Openni2Device(std::string uri, DeviceEvents& events) : uri_(std::move(uri)), events_(events) {}

  [[nodiscard]] Error Refusal(const std::string& what) const;
  Result<void> StartDepth(const StreamRequest& request, StreamDetails* details);
  void StartColor(const StreamRequest& request, StreamDetails* details);
  void Register(StreamDetails* details);
  bool ReadStream(openni::VideoStream& stream, openni::VideoFrameRef* frame);
  void WaitForColor();
  Result<openni::CameraSettings*> ColorSettings();

  std::string uri_;  // As it was asked for.
  DeviceEvents& events_;
  struct Handles {
    openni::Device device;
    openni::VideoStream depth;
    openni::VideoStream color;
  };
  std::unique_ptr<Handles> handles_ = std::make_unique<Handles>();
  openni::Device& device_ = handles_->device;
  openni::VideoStream& depth_ = handles_->depth;
  openni::VideoStream& color_ = handles_->color;
  openni::VideoFrameRef depth_frame_;
  openni::VideoFrameRef color_frame_;
  bool is_recording_ = false;
  int64_t period_us_ = 33'333;
  int num_frames_ = 0;  // Of a recording; 0: it does not say.
  int num_read_ = 0;
};

}  // namespace vantage
