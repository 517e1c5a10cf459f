#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/result.h"
#include "drivers/camera/camera_device.h"
#include "drivers/camera/frame_pairing.h"
#include "drivers/v4l2/frame_converter.h"
#include "drivers/v4l2/v4l2_stream.h"

namespace vantage {

/// The color stream of one node beside the depth stream of another, on the same clock.
class PairedColor {
 public:
  /// Starts color of the size and at the rate of the request.
  /// Errors: as of V4l2Stream.
  static Result<std::unique_ptr<PairedColor>> Start(const std::string& path,
                                                    const StreamRequest& request);

  /// The image nearest to a depth image, which lives until the next call. Waits for it if it is
  /// still to come, up to a period. Nothing: there is none within half a period.
  std::optional<RawImage> Find(int64_t depth_us);

  /// The node was unplugged, or failed several times in a row.
  [[nodiscard]] bool is_gone() const { return is_gone_; }
  [[nodiscard]] bool has_stamps() const { return stream_->has_stamps(); }
  V4l2Controls& controls() { return stream_->controls(); }

 private:
  // A color image of FramePairing's slots.
  struct Slot {
    FrameConverter converter;
    std::vector<std::byte> copy;  // Of an image that the converter leaves in the driver's buffer.
    RawImage image;
  };

  PairedColor(std::unique_ptr<V4l2Stream> stream, const StreamRequest& request);
  // False: none came.
  bool ReadOne(std::chrono::milliseconds timeout);

  std::unique_ptr<V4l2Stream> stream_;
  std::chrono::microseconds period_;
  FramePairing pairing_;
  std::vector<Slot> slots_;  // Those of the pairing, and one more at the end.
  bool is_gone_ = false;
  int num_errors_ = 0;  // One after the other.
};

}  // namespace vantage
