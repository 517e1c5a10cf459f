#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace vantage {

/// Brightness, 0 black to 255 white, row by row.
struct GrayImage {
  int width = 0;
  int height = 0;
  std::vector<uint8_t> pixels;  ///< width * height values

  GrayImage() = default;
  GrayImage(int width_px, int height_px, uint8_t fill = 0)
      : width(width_px),
        height(height_px),
        pixels(static_cast<size_t>(width_px) * static_cast<size_t>(height_px), fill) {}

  [[nodiscard]] size_t Index(int u, int v) const {
    return static_cast<size_t>(v) * static_cast<size_t>(width) + static_cast<size_t>(u);
  }
  [[nodiscard]] uint8_t at(int u, int v) const { return pixels[Index(u, v)]; }
  uint8_t& at(int u, int v) { return pixels[Index(u, v)]; }
};

}  // namespace vantage
