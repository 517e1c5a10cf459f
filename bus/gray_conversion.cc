#include "bus/gray_conversion.h"

#include <algorithm>

#include "bus/image_conversion.h"
#include "bus/message_time.h"
#include "common/format.h"
#include "common/jpeg_decoder.h"

namespace vantage {
namespace {

/// Luma of ITU-R BT.601 in 16 bits, its weights summing to 2^16.
uint8_t Luma(unsigned red, unsigned green, unsigned blue) {
  return static_cast<uint8_t>((19595U * red + 38470U * green + 7471U * blue + 32768U) >> 16U);
}

Result<GrayImage> GrayFromJpeg(const image_t& image) {
  if (image.width < 1 || image.height < 1 || image.width > kMaxImageSide ||
      image.height > kMaxImageSide) {
    return Error{ErrorCode::kCorrupt,
                 Format("JPEG image of %d x %d px, expected sides of 1 to %d px",
                        image.width,
                        image.height,
                        kMaxImageSide)};
  }
  GrayImage gray;
  Result<void> decoded =
      DecodeJpeg(image.data, image.width, image.height, JpegPixels::kGray, &gray.pixels);
  if (!decoded) return decoded.error();
  gray.width = image.width;
  gray.height = image.height;
  return gray;
}

Result<GrayImage> GrayFromImage(const image_t& image) {
  if (image.pixelformat == image_t::PIXEL_FORMAT_MJPEG) return GrayFromJpeg(image);
  const size_t bytes_per_pixel = BytesPerPixel(image.pixelformat);
  if (bytes_per_pixel == 0) {
    return Error{
        ErrorCode::kInvalidArgument,
        Format("image of pixel format %d, expected gray, RGB, BGR or MJPEG", image.pixelformat)};
  }
  const bool sized = image.width >= 1 && image.height >= 1 && image.width <= kMaxImageSide &&
                     image.height <= kMaxImageSide && image.row_stride >= 0;
  const auto width = static_cast<size_t>(std::max(image.width, 0));
  const auto height = static_cast<size_t>(std::max(image.height, 0));
  const auto stride = static_cast<size_t>(std::max(image.row_stride, 0));
  if (!sized || stride < bytes_per_pixel * width || image.data.size() != stride * height) {
    return Error{ErrorCode::kCorrupt,
                 Format("image of %d x %d px, row stride %d, %zu bytes: expected sides of 1 to %d "
                        "px, a row stride of %zu bytes a pixel or more, and rows as they say",
                        image.width,
                        image.height,
                        image.row_stride,
                        image.data.size(),
                        kMaxImageSide,
                        bytes_per_pixel)};
  }
  GrayImage gray(image.width, image.height);
  const bool is_bgr = image.pixelformat == image_t::PIXEL_FORMAT_BGR;
  for (size_t v = 0; v < height; ++v) {
    const uint8_t* row = image.data.data() + v * stride;
    uint8_t* out = gray.pixels.data() + v * width;
    if (bytes_per_pixel == 1) {
      std::copy_n(row, width, out);
      continue;
    }
    for (size_t u = 0; u < width; ++u, row += 3) {
      out[u] = is_bgr ? Luma(row[2], row[1], row[0]) : Luma(row[0], row[1], row[2]);
    }
  }
  return gray;
}

}  // namespace

Result<GrayFrame> GrayFrameFromMessage(const images_t& message) {
  if (Result<void> timed = CheckUtime("images_t.utime", message.utime); !timed) {
    return timed.error();
  }
  const size_t num_images = std::min(message.images.size(), message.image_types.size());
  for (size_t i = 0; i < num_images; ++i) {
    if (message.image_types[i] != images_t::LEFT) continue;
    Result<GrayImage> gray = GrayFromImage(message.images[i]);
    if (!gray) return gray.error();
    return GrayFrame{message.utime, std::move(gray).value()};
  }
  return Error{ErrorCode::kNotFound,
               Format("images_t with %zu images has no color or gray one, expected one of type %d; "
                      "a camera sends it with color = true",
                      num_images,
                      images_t::LEFT)};
}

}  // namespace vantage
