#pragma once

#include <cstdint>

#include "common/gray_image.h"
#include "common/result.h"
#include "vantage/images_t.hpp"

namespace vantage {

/// A color or gray image as it comes over the bus, as brightness.
struct GrayFrame {
  int64_t utime = 0;  ///< us since the epoch, of the exposure
  GrayImage image;
};

/// The first image of type LEFT, its pixels gray, RGB, BGR or MJPEG; color as luma (ITU-R
/// BT.601). Errors: as CheckUtime; none there; another pixel format; a side outside
/// 1..kMaxImageSide; a row stride or number of bytes that does not belong to the size; as
/// DecodeJpeg.
Result<GrayFrame> GrayFrameFromMessage(const images_t& message);

}  // namespace vantage
