#include "drivers/openni2/openni2_color.h"

#include <cstdint>
#include <cstring>

namespace vantage {
namespace {

std::byte Luma(const std::byte* rgb) {
  // Of weights that sum to 2^16.
  return static_cast<std::byte>((19595U * std::to_integer<unsigned>(rgb[0]) +
                                 38470U * std::to_integer<unsigned>(rgb[1]) +
                                 7471U * std::to_integer<unsigned>(rgb[2]) + 32768U) >>
                                16U);
}

}  // namespace

RawImage ConvertColor(const RawImage& image,
                      bool to_gray,
                      bool flip,
                      std::vector<std::byte>* buffer) {
  const bool is_rgb = image.layout == PixelLayout::kRgb8;
  to_gray = to_gray && is_rgb;
  if ((!to_gray && !flip) || image.width <= 0 || image.height <= 0) return image;
  const size_t width = static_cast<size_t>(image.width);
  const size_t height = static_cast<size_t>(image.height);
  const size_t pixel_in = is_rgb ? 3 : 1;
  const size_t pixel_out = to_gray ? 1 : pixel_in;
  if (image.data.size() != pixel_in * width * height ||
      image.stride_bytes != static_cast<int64_t>(pixel_in * width)) {
    return image;
  }
  buffer->resize(pixel_out * width * height);
  const std::byte* in = image.data.data();
  for (size_t v = 0; v < height; ++v) {
    std::byte* row = buffer->data() + v * width * pixel_out;
    for (size_t u = 0; u < width; ++u, in += pixel_in) {
      std::byte* out = row + (flip ? width - 1 - u : u) * pixel_out;
      if (to_gray) {
        *out = Luma(in);
      } else {
        std::memcpy(out, in, pixel_in);
      }
    }
  }
  RawImage converted = image;
  converted.layout = to_gray ? PixelLayout::kGray8 : image.layout;
  converted.stride_bytes = static_cast<int>(pixel_out * width);
  converted.data = *buffer;
  return converted;
}

}  // namespace vantage
