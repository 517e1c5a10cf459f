#pragma once

#include <linux/videodev2.h>

#include <cstdint>
#include <string>

#include "common/result.h"
#include "drivers/camera/camera_device.h"
#include "drivers/v4l2/pixel_conversion.h"
#include "drivers/v4l2/pixel_format.h"

namespace vantage {

/// No image that this driver reads is larger.
inline constexpr int64_t kLargestImage = int64_t{256} << 20;  // bytes

/// What driver and program agreed on.
struct StreamFormat {
  const PixelFormat* pixel = nullptr;
  int width = 0;             ///< px
  int height = 0;            ///< px
  int64_t stride_bytes = 0;  ///< from one row to the next; 0: compressed
  int64_t image_bytes = 0;   ///< to the end of the last row's last pixel; 0: compressed
  YuvEncoding yuv;           ///< where it is 4:2:2

  bool operator==(const StreamFormat&) const = default;
};

/// What the driver answered to VIDIOC_S_FMT or VIDIOC_G_FMT.
/// Errors: it is not what was asked for; interlaced fields; more than one plane; rows that overlap;
/// images of no bytes or more than kLargestImage.
Result<StreamFormat> CheckFormat(const v4l2_format& answer,
                                 const PixelFormat& pixel,
                                 const StreamRequest& request,
                                 const std::string& path);

/// Agrees on a format with an open device. @param buffer_type as for ReadVideoFormats()
/// Errors: as above, and what the driver refuses.
Result<StreamFormat> SetFormat(int fd,
                               uint32_t buffer_type,
                               const PixelFormat& pixel,
                               const StreamRequest& request,
                               const std::string& path);

/// Errors: the format is no longer the one agreed on.
Result<void> ConfirmFormat(int fd,
                           uint32_t buffer_type,
                           const StreamFormat& agreed,
                           const StreamRequest& request,
                           const std::string& path);

/// Asks for a rate. @return Hz, what the driver answered; 0: it can't be set, or it does not say.
double SetRate(int fd, uint32_t buffer_type, int fps);

}  // namespace vantage
