#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace vantage {

/// Depth along the optical axis, m, row by row; NaN where there is no measurement.
struct DepthImage {
  static constexpr float kInvalid = std::numeric_limits<float>::quiet_NaN();

  int width = 0;
  int height = 0;
  std::vector<float> depth;  ///< width * height values

  DepthImage() = default;
  DepthImage(int width_px, int height_px, float fill = kInvalid)
      : width(width_px),
        height(height_px),
        depth(static_cast<size_t>(width_px) * static_cast<size_t>(height_px), fill) {}

  [[nodiscard]] size_t Index(int u, int v) const {
    return static_cast<size_t>(v) * static_cast<size_t>(width) + static_cast<size_t>(u);
  }
  [[nodiscard]] bool Contains(int u, int v) const {
    return u >= 0 && v >= 0 && u < width && v < height;
  }
  [[nodiscard]] float at(int u, int v) const { return depth[Index(u, v)]; }
  float& at(int u, int v) { return depth[Index(u, v)]; }
};

/// From the wire's millimetres (0 = none). `millimetres` has width * height values.
inline DepthImage DepthFromMillimetres(int width, int height, const uint16_t* millimetres) {
  DepthImage image(width, height);
  for (size_t i = 0; i < image.depth.size(); ++i) {
    if (millimetres[i] != 0) image.depth[i] = 1e-3F * static_cast<float>(millimetres[i]);
  }
  return image;
}

/// To the wire's millimetres; what is invalid, not positive or beyond 65.535 m becomes 0.
inline std::vector<uint16_t> DepthToMillimetres(const DepthImage& image) {
  std::vector<uint16_t> millimetres(image.depth.size(), 0);
  for (size_t i = 0; i < image.depth.size(); ++i) {
    const float value = std::round(1e3F * image.depth[i]);
    if (value >= 1.0F && value <= 65535.0F) millimetres[i] = static_cast<uint16_t>(value);
  }
  return millimetres;
}

}  // namespace vantage
