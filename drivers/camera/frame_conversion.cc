#include "drivers/camera/frame_conversion.h"

#include <algorithm>
#include <cstring>

#include "common/format.h"

namespace vantage {
namespace {

constexpr size_t kDepthBytes = 2;

// Bytes a pixel; 0 for a file.
size_t PixelBytes(PixelLayout layout) {
  switch (layout) {
    case PixelLayout::kDepth16:
      return kDepthBytes;
    case PixelLayout::kRgb8:
      return 3;
    case PixelLayout::kGray8:
      return 1;
    case PixelLayout::kJpeg:
      break;
  }
  return 0;
}

std::string ImageFault(const char* name, const RawImage& image) {
  const size_t pixel_bytes = PixelBytes(image.layout);
  if (image.width > 0 && image.height > 0 && image.data.data() != nullptr) {
    const size_t row = pixel_bytes * static_cast<size_t>(image.width);
    if (pixel_bytes == 0 && !image.data.empty()) return {};
    if (image.stride_bytes > 0 && static_cast<size_t>(image.stride_bytes) == row &&
        image.data.size() == row * static_cast<size_t>(image.height)) {
      return {};
    }
  }
  return Format("%s frame of %d x %d px with %zu bytes in rows of %d, expected %zu bytes a pixel",
                name,
                image.width,
                image.height,
                image.data.size(),
                image.stride_bytes,
                pixel_bytes);
}

}  // namespace

std::string FrameFault(const RawFrame& frame, const StreamDetails& details) {
  const std::optional<RawImage>& main = details.has_depth ? frame.depth : frame.color;
  const char* name = details.has_depth ? "depth" : "color";
  if (!main) return Format("frame without a %s image", name);
  if (main->width != details.width || main->height != details.height) {
    return Format("%s frame of %d x %d px, expected %d x %d",
                  name,
                  main->width,
                  main->height,
                  details.width,
                  details.height);
  }
  std::string fault = frame.depth ? ImageFault("depth", *frame.depth) : std::string();
  if (fault.empty() && frame.color) fault = ImageFault("color", *frame.color);
  return fault;
}

std::vector<uint16_t> DepthMillimetres(const RawImage& depth, const StreamDetails& details) {
  const size_t width = static_cast<size_t>(depth.width);
  std::vector<uint16_t> millimetres(width * static_cast<size_t>(depth.height));
  std::memcpy(millimetres.data(), depth.data.data(), kDepthBytes * millimetres.size());
  if (details.depth_unit_um != 1000) {
    for (uint16_t& value : millimetres) {
      value = static_cast<uint16_t>((value * details.depth_unit_um + 500) / 1000);
    }
  }
  if (details.mirrored) {
    for (auto row = millimetres.begin(); row != millimetres.end();
         row += static_cast<std::ptrdiff_t>(width)) {
      std::reverse(row, row + static_cast<std::ptrdiff_t>(width));
    }
  }
  return millimetres;
}

ColorImage ColorImageOf(const RawImage& color, const StreamDetails& details) {
  ColorImage image;
  image.layout = color.layout;
  image.width = color.width;
  image.height = color.height;
  image.data.resize(color.data.size());
  std::memcpy(image.data.data(), color.data.data(), image.data.size());
  const size_t pixel = PixelBytes(color.layout);
  if (!details.mirrored || pixel == 0) return image;
  const size_t width = static_cast<size_t>(color.width);
  for (size_t v = 0; v < static_cast<size_t>(color.height); ++v) {
    uint8_t* left = &image.data[pixel * width * v];
    uint8_t* right = left + pixel * (width - 1);
    for (; left < right; left += pixel, right -= pixel) {
      std::swap_ranges(left, left + pixel, right);
    }
  }
  return image;
}

}  // namespace vantage
