#include "tools/viewer/image_color.h"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "bus/image_conversion.h"
#include "common/jpeg_decoder.h"

namespace vantage {
namespace {

// RGB, 3 bytes a pixel.
std::optional<std::vector<uint8_t>> DecodeColor(const image_t& image) {
  if (image.width < 1 || image.height < 1 || image.width > kMaxImageSide ||
      image.height > kMaxImageSide) {
    return std::nullopt;
  }
  std::vector<uint8_t> rgb;
  if (image.pixelformat == image_t::PIXEL_FORMAT_MJPEG) {
    if (!DecodeJpeg(image.data, image.width, image.height, JpegPixels::kRgb, &rgb)) {
      return std::nullopt;
    }
    return rgb;
  }
  const bool is_gray = image.pixelformat == image_t::PIXEL_FORMAT_GRAY;
  const bool is_bgr = image.pixelformat == image_t::PIXEL_FORMAT_BGR;
  if (!is_gray && !is_bgr && image.pixelformat != image_t::PIXEL_FORMAT_RGB) return std::nullopt;
  const auto width = static_cast<size_t>(image.width);
  const auto height = static_cast<size_t>(image.height);
  const size_t depth = is_gray ? 1 : 3;
  const auto stride = static_cast<size_t>(std::max(0, image.row_stride));
  if (stride < depth * width || image.data.size() < stride * height) return std::nullopt;
  rgb.resize(3 * width * height);
  for (size_t v = 0; v < height; ++v) {
    for (size_t u = 0; u < width; ++u) {
      const uint8_t* from = image.data.data() + v * stride + u * depth;
      uint8_t* to = rgb.data() + 3 * (v * width + u);
      for (size_t i = 0; i < 3; ++i) to[i] = is_gray ? from[0] : from[is_bgr ? 2 - i : i];
    }
  }
  return rgb;
}

}  // namespace

PixelColor ColorOf(const images_t& images, const DepthImage& depth) {
  const size_t count = std::min(images.images.size(), images.image_types.size());
  for (size_t i = 0; i < count; ++i) {
    if (images.image_types[i] != images_t::LEFT) continue;
    const image_t& image = images.images[i];
    std::optional<std::vector<uint8_t>> rgb = DecodeColor(image);
    if (!rgb) return {};
    auto shared = std::make_shared<const std::vector<uint8_t>>(std::move(*rgb));
    return [shared,
            width = image.width,
            height = image.height,
            depth_width = depth.width,
            depth_height = depth.height](int u, int v) {
      const int column = static_cast<int>(int64_t{u} * width / depth_width);
      const int row = static_cast<int>(int64_t{v} * height / depth_height);
      const uint8_t* at =
          shared->data() +
          3 * (static_cast<size_t>(row) * static_cast<size_t>(width) + static_cast<size_t>(column));
      return Rgb{at[0], at[1], at[2]};
    };
  }
  return {};
}

}  // namespace vantage
