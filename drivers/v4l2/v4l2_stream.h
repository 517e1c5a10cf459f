#pragma once

#include <memory>
#include <optional>
#include <string>

#include "common/result.h"
#include "drivers/camera/camera_device.h"
#include "drivers/v4l2/capture_queue.h"
#include "drivers/v4l2/stream_format.h"
#include "drivers/v4l2/v4l2_controls.h"
#include "drivers/v4l2/v4l2_ioctl.h"

namespace vantage {

/// One node of video4linux that is open, and streams once it was started.
class V4l2Stream {
 public:
  /// What a stream may be of.
  enum class Kind { kAny, kColor };

  /// Errors: as of OpenVideoNode(), ReadCapability() and CheckCapture().
  static Result<std::unique_ptr<V4l2Stream>> Open(const std::string& path);

  /// @param pixel_format as of ChooseFormat()
  /// Errors: it has no such format; what the driver refuses; another program streams from it.
  Result<void> Start(const StreamRequest& request, const std::string& pixel_format, Kind kind);

  /// As of CaptureQueue; after Start().
  CaptureQueue::Outcome Read(std::chrono::milliseconds timeout, CapturedBuffer* captured) {
    return queue_->Dequeue(timeout, captured);
  }

  [[nodiscard]] const StreamFormat& format() const { return format_; }
  /// Hz; 0: the driver does not say.
  [[nodiscard]] double rate_hz() const { return rate_hz_; }
  [[nodiscard]] bool has_stamps() const { return queue_->has_stamps(); }
  V4l2Controls& controls() { return controls_; }

 private:
  V4l2Stream(const std::string& path, FileDescriptor fd, uint32_t buffer_type);

  std::string path_;
  FileDescriptor fd_;  // Before what uses it.
  uint32_t buffer_type_;
  V4l2Controls controls_;
  StreamFormat format_;
  double rate_hz_ = 0.0;
  std::unique_ptr<CaptureQueue> queue_;  // Null before Start().
};

}  // namespace vantage
