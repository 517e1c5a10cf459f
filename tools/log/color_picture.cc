#include "tools/log/color_picture.h"

#include <algorithm>
#include <cstddef>

#include "bus/image_conversion.h"
#include "common/format.h"
#include "common/jpeg_decoder.h"

namespace vantage {

const image_t* FindColor(const images_t& images) {
  const size_t count = std::min(images.images.size(), images.image_types.size());
  for (size_t i = 0; i < count; ++i) {
    if (images.image_types[i] == images_t::LEFT) return &images.images[i];
  }
  return nullptr;
}

Result<RgbImage> ColorPicture(const image_t& image) {
  const auto malformed = [&image] {
    return Error{ErrorCode::kCorrupt,
                 Format("color image of %d x %d px, format %d, %zu bytes, expected gray, RGB, BGR "
                        "or MJPEG and the bytes for it",
                        image.width,
                        image.height,
                        image.pixelformat,
                        image.data.size())};
  };
  if (image.width < 1 || image.height < 1 || image.width > kMaxImageSide ||
      image.height > kMaxImageSide) {
    return malformed();
  }
  RgbImage picture{.width = image.width, .height = image.height, .rgb = {}};
  if (image.pixelformat == image_t::PIXEL_FORMAT_MJPEG) {
    const Result<void> decoded =
        DecodeJpeg(image.data, image.width, image.height, JpegPixels::kRgb, &picture.rgb);
    if (!decoded) return decoded.error();
    return picture;
  }
  const auto width = static_cast<size_t>(image.width);
  const auto height = static_cast<size_t>(image.height);
  const size_t bytes = BytesPerPixel(image.pixelformat);
  const size_t stride = image.row_stride < 0 ? 0 : static_cast<size_t>(image.row_stride);
  if (bytes == 0 || stride < bytes * width || image.data.size() != stride * height) {
    return malformed();
  }
  const bool is_bgr = image.pixelformat == image_t::PIXEL_FORMAT_BGR;
  picture.rgb.reserve(3 * width * height);
  for (size_t v = 0; v < height; ++v) {
    for (size_t u = 0; u < width; ++u) {
      const uint8_t* pixel = &image.data[v * stride + u * bytes];
      for (size_t i = 0; i < 3; ++i) {
        picture.rgb.push_back(bytes == 1 ? pixel[0] : pixel[is_bgr ? 2 - i : i]);
      }
    }
  }
  return picture;
}

}  // namespace vantage
