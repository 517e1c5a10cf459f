#include "common/depth_codec/depth_window.h"

#include "common/check.h"
#include "common/depth_codec/depth_payload.h"

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
  VANTAGE_CHECK(width > 0 && width <= kMaxDepthSide, "a depth image is 1 to 4096 px wide");
  const size_t height = depth.size() / width;
  size_t top = 0;
  while (top < height && IsEmpty(depth.subspan(top * width, width))) ++top;
  if (top == height) return {};
  size_t bottom = height;
  while (IsEmpty(depth.subspan((bottom - 1) * width, width))) --bottom;
  // What is in a column anywhere.
  uint16_t any[kMaxDepthSide] = {};
  for (size_t v = top; v < bottom; ++v) {
    const uint16_t* row = depth.data() + v * width;
    for (size_t u = 0; u < width; ++u) any[u] = static_cast<uint16_t>(any[u] | row[u]);
  }
  size_t left = 0;
  while (any[left] == 0) ++left;
  size_t right = width;
  while (any[right - 1] == 0) --right;
  return {left, top, right - left, bottom - top};
}

}  // namespace vantage
