#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "drivers/camera/camera_device.h"
#include "drivers/v4l2/disparity_model.h"
#include "drivers/v4l2/stream_format.h"

namespace vantage {

/// Makes of a buffer's bytes an image in a layout of PixelLayout.
class FrameConverter {
 public:
  /// @param color_layout of a color format; kJpeg only where the format is JPEG
  FrameConverter(const StreamFormat& format,
                 PixelLayout color_layout,
                 const DisparityModel& disparity);

  /// `image` refers to `data` where that can be used as it is, else to memory of this object that
  /// the next call overwrites. Its stamp is left alone.
  /// @return why it can't be used, in one sentence; empty when it can.
  std::string Convert(std::span<const std::byte> data, RawImage* image);

 private:
  void ConvertRows(const PixelRows& rows);
  void ConvertColor(const PixelRows& rows, uint8_t* pixels);

  StreamFormat format_;
  PixelLayout layout_;
  std::array<uint16_t, 1024> table_;  // Of raw disparities.
  int64_t packed_row_bytes_;
  bool as_it_is_;
  std::vector<uint8_t> converted_;
  std::vector<uint8_t> rgb_;  // On the way to gray.
};

}  // namespace vantage
