#include "drivers/openni2/frame_conversion.h"

#include <algorithm>
#include <cstring>

#include "common/format.h"

namespace vantage {
namespace {

constexpr size_t kDepthBytes = 2;
constexpr size_t kColorBytes = 3;

std::string ImageFault(const char* name, const RawImage& image, size_t pixel_bytes) {
  if (image.width > 0 && image.height > 0 && image.data.data() != nullptr) {
    const size_t row = pixel_bytes * static_cast<size_t>(image.width);
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
  if (frame.depth.width != details.width || frame.depth.height != details.height) {
    return Format("depth frame of %d x %d px, expected %d x %d",
                  frame.depth.width,
                  frame.depth.height,
                  details.width,
                  details.height);
  }
  std::string fault = ImageFault("depth", frame.depth, kDepthBytes);
  if (fault.empty() && frame.color) fault = ImageFault("color", *frame.color, kColorBytes);
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

std::vector<uint8_t> ColorRgb(const RawImage& color, const StreamDetails& details) {
  const size_t width = static_cast<size_t>(color.width);
  const size_t height = static_cast<size_t>(color.height);
  std::vector<uint8_t> rgb(kColorBytes * width * height);
  std::memcpy(rgb.data(), color.data.data(), rgb.size());
  if (details.mirrored) {
    for (size_t v = 0; v < height; ++v) {
      uint8_t* left = &rgb[kColorBytes * width * v];
      uint8_t* right = left + kColorBytes * (width - 1);
      for (; left < right; left += kColorBytes, right -= kColorBytes) {
        std::swap_ranges(left, left + kColorBytes, right);
      }
    }
  }
  return rgb;
}

}  // namespace vantage
