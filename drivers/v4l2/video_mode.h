#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/result.h"
#include "drivers/camera/camera_device.h"
#include "drivers/v4l2/pixel_format.h"

namespace vantage {

/// Values from `lowest` to `highest`, `step` apart; 0: every one.
struct ModeRange {
  double lowest = 0.0;
  double highest = 0.0;
  double step = 0.0;

  [[nodiscard]] bool Contains(double value) const;
  bool operator==(const ModeRange&) const = default;
};

/// Image sizes, and the rates at which they come.
struct VideoSize {
  ModeRange width;               ///< px
  ModeRange height;              ///< px
  std::vector<ModeRange> rates;  ///< Hz; empty: the driver does not say

  bool operator==(const VideoSize&) const = default;
};

/// What a device offers in one pixel format.
struct VideoFormat {
  uint32_t fourcc = 0;
  std::string description;       ///< the driver's words
  std::vector<VideoSize> sizes;  ///< empty: the driver does not say
};

/// What an open device offers. Where a size is a range, its rates are those of width x height if it
/// contains that, else those of its largest.
/// @param buffer_type V4L2_BUF_TYPE_VIDEO_CAPTURE or .._MPLANE
std::vector<VideoFormat> ReadVideoFormats(int fd, uint32_t buffer_type, int width, int height);

/// The format to ask of a device.
/// @param wanted a name of PixelFormat, or "auto": the first of its list that fits the request.
/// Errors: none has this size at this rate, which names those there are.
Result<const PixelFormat*> ChooseFormat(const std::vector<VideoFormat>& formats,
                                        const std::string& wanted,
                                        const StreamRequest& request,
                                        const std::string& path);

/// "640x480", "16-1920x16-1080"
std::string SizeText(const VideoSize& size);
/// "30, 15 Hz"; empty where the driver does not say.
std::string RatesText(const VideoSize& size);
/// "YUYV (640x480 at 30 Hz, ...), MJPG (...)", of those that are read; "none".
std::string FormatsText(const std::vector<VideoFormat>& formats);

}  // namespace vantage
