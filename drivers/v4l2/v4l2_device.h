#pragma once

#include <memory>
#include <optional>
#include <string>

#include "drivers/camera/camera_device.h"
#include "drivers/v4l2/capture_queue.h"
#include "drivers/v4l2/disparity_model.h"
#include "drivers/v4l2/frame_converter.h"
#include "drivers/v4l2/v4l2_controls.h"
#include "drivers/v4l2/v4l2_ioctl.h"
#include "drivers/v4l2/video_node.h"

namespace vantage {

/// What is asked of V4L2 devices beside a StreamRequest.
struct V4l2Options {
  std::string pixel_format = "auto";  ///< a name of PixelFormat; "auto": the best that fits
  int depth_unit_um = 1000;           ///< um, of Z16 and Y16: 1 to 1,000,000
  DisparityModel disparity;           ///< of Y10B
};

/// CameraDevice on a node of video4linux.
class V4l2Device : public CameraDevice {
 public:
  /// @param serial of its USB device, empty if it has none.
  /// Errors: as of OpenVideoNode(), ReadCapability() and CheckCapture().
  static Result<std::unique_ptr<CameraDevice>> Open(const std::string& path,
                                                    const std::string& serial,
                                                    const V4l2Options& options);

  [[nodiscard]] std::string serial() const override { return serial_; }
  Result<StreamDetails> Start(const StreamRequest& request) override;
  ReadResult Read(std::chrono::milliseconds timeout, RawFrame* frame) override;
  Result<void> SetExposure(int exposure_us) override { return controls_.SetExposure(exposure_us); }
  Result<void> SetGain(int gain) override { return controls_.SetGain(gain); }
  Result<void> SetControl(const std::string& name, int64_t value) override {
    return controls_.Set(name, value);
  }

 private:
  V4l2Device(const std::string& path,
             const std::string& serial,
             const V4l2Options& options,
             FileDescriptor fd,
             uint32_t buffer_type);

  [[nodiscard]] StreamDetails Details(const StreamFormat& format,
                                      const StreamRequest& request,
                                      double rate_hz) const;

  std::string path_;
  std::string serial_;
  V4l2Options options_;
  FileDescriptor fd_;  // Before what uses it.
  uint32_t buffer_type_;
  V4l2Controls controls_;
  std::unique_ptr<CaptureQueue> queue_;  // Null before Start().
  std::optional<FrameConverter> converter_;
  int num_errors_ = 0;  // One after the other.
};

}  // namespace vantage
