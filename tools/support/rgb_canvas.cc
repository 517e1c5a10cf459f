#include "tools/support/rgb_canvas.h"

#include <algorithm>
#include <cmath>

namespace vantage {
namespace {

size_t Offset(const RgbImage& image, int u, int v) {
  return 3 * (static_cast<size_t>(v) * static_cast<size_t>(image.width) + static_cast<size_t>(u));
}

bool Contains(const RgbImage& image, int u, int v) {
  return u >= 0 && v >= 0 && u < image.width && v < image.height;
}

// Pixel bounds of [low, high], within [0, size - 1]; safe for any finite or infinite value.
int LowPixel(double low, int size) {
  return static_cast<int>(std::clamp(std::floor(low), 0.0, static_cast<double>(size)));
}
int HighPixel(double high, int size) {
  return static_cast<int>(std::clamp(std::ceil(high), -1.0, static_cast<double>(size - 1)));
}

}  // namespace

RgbImage FilledImage(int width, int height, Rgb color) {
  RgbImage image;
  image.width = width;
  image.height = height;
  image.rgb.resize(3 * static_cast<size_t>(width) * static_cast<size_t>(height));
  for (size_t i = 0; i < image.rgb.size(); i += 3) {
    image.rgb[i] = color.r;
    image.rgb[i + 1] = color.g;
    image.rgb[i + 2] = color.b;
  }
  return image;
}

Rgb PixelAt(const RgbImage& image, int u, int v) {
  const size_t at = Offset(image, u, v);
  return {image.rgb[at], image.rgb[at + 1], image.rgb[at + 2]};
}

void SetPixel(RgbImage& image, int u, int v, Rgb color) {
  if (!Contains(image, u, v)) return;
  const size_t at = Offset(image, u, v);
  image.rgb[at] = color.r;
  image.rgb[at + 1] = color.g;
  image.rgb[at + 2] = color.b;
}

void BlendPixel(RgbImage& image, int u, int v, Rgb color, double coverage) {
  if (!Contains(image, u, v) || !(coverage > 0.0)) return;
  SetPixel(image, u, v, Mix(PixelAt(image, u, v), color, std::min(coverage, 1.0)));
}

void DrawLine(RgbImage& image,
              const Eigen::Vector2d& from,
              const Eigen::Vector2d& to,
              double width,
              Rgb color) {
  if (!from.allFinite() || !to.allFinite()) return;
  const double reach = 0.5 * width + 1.0;
  const Eigen::Vector2d low = from.cwiseMin(to).array() - reach;
  const Eigen::Vector2d high = from.cwiseMax(to).array() + reach;
  const Eigen::Vector2d along = to - from;
  const double length2 = along.squaredNorm();
  for (int v = LowPixel(low.y(), image.height); v <= HighPixel(high.y(), image.height); ++v) {
    for (int u = LowPixel(low.x(), image.width); u <= HighPixel(high.x(), image.width); ++u) {
      const Eigen::Vector2d pixel(u, v);
      const double share =
          length2 > 0.0 ? std::clamp((pixel - from).dot(along) / length2, 0.0, 1.0) : 0.0;
      const double distance = (pixel - from - share * along).norm();
      BlendPixel(image, u, v, color, std::clamp(0.5 * width + 0.5 - distance, 0.0, 1.0));
    }
  }
}

void DrawDisk(RgbImage& image, const Eigen::Vector2d& center, double radius, Rgb color) {
  DrawLine(image, center, center, 2.0 * radius, color);
}

RgbImage Downsample(const RgbImage& image, int factor) {
  RgbImage small = FilledImage(image.width / factor, image.height / factor, {});
  const int count = factor * factor;
  for (int v = 0; v < small.height; ++v) {
    for (int u = 0; u < small.width; ++u) {
      int sum[3] = {0, 0, 0};
      for (int dv = 0; dv < factor; ++dv) {
        for (int du = 0; du < factor; ++du) {
          const Rgb pixel = PixelAt(image, u * factor + du, v * factor + dv);
          sum[0] += pixel.r;
          sum[1] += pixel.g;
          sum[2] += pixel.b;
        }
      }
      const auto mean = [count](int total) {
        return static_cast<uint8_t>((total + count / 2) / count);
      };
      SetPixel(small, u, v, {mean(sum[0]), mean(sum[1]), mean(sum[2])});
    }
  }
  return small;
}

}  // namespace vantage
