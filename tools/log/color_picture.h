#pragma once

#include "common/result.h"
#include "tools/support/png_image.h"
#include "vantage/images_t.hpp"

namespace vantage {

/// The first image of type LEFT; null when there is none.
const image_t* FindColor(const images_t& images);

/// Pixels gray, RGB, BGR or MJPEG. Errors: another format, a side outside 1..kMaxImageSide, bytes
/// that do not belong to the size, as DecodeJpeg.
Result<RgbImage> ColorPicture(const image_t& image);

}  // namespace vantage
