#include "common/depth_codec/depth_window.h"

#include <algorithm>

namespace vantage {
namespace {

// Without an early end, so that it runs on vectors.
bool IsEmpty(std::span<const uint16_t> row) {
  uint16_t any = 0;
  for (const uint16_t value : row) any = static_cast<uint16_t>(any | value);
  return any == 0;
}

}  // namespace

DepthWindow FindDepthWindow(std::span<const uint16_t> depth, size_t width) {
  const size_t height = depth.size() / width;
  size_t top = 0;
  while (top < height && IsEmpty(depth.subspan(top * width, width))) ++top;
  if (top == height) return {};
  size_t bottom = height;
  while (IsEmpty(depth.subspan((bottom - 1) * width, width))) --bottom;
  // Each row is looked at only beside the columns that are known to be needed.
  size_t left = width;
  size_t right = 0;
  for (size_t v = top; v < bottom; ++v) {
    const uint16_t* row = depth.data() + v * width;
    left = static_cast<size_t>(
        std::find_if(row, row + left, [](uint16_t value) { return value != 0; }) - row);
    for (size_t u = width; u > right; --u) {
      if (row[u - 1] == 0) continue;
      right = u;
      break;
    }
  }
  return {left, top, right - left, bottom - top};
}

}  // namespace vantage
