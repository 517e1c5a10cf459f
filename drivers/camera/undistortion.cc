#include "drivers/camera/undistortion.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "common/check.h"
#include "common/simd.h"

namespace vantage {
namespace {

constexpr unsigned kWhole = 256;  // Of a share.

using Bytes = uint8_t __attribute__((vector_size(16)));
using Words = uint16_t __attribute__((vector_size(16)));

// Where the ray of an ideal pixel falls in the distorted image, px.
Eigen::Vector2d DistortedPixel(const CameraIntrinsics& intrinsics, int u, int v) {
  const CameraModel& camera = intrinsics.camera;
  const Eigen::Vector2d shown =
      intrinsics.distortion.Distort({(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy});
  return {camera.fx * shown.x() + camera.cx, camera.fy * shown.y() + camera.cy};
}

// Within half a pixel of some pixel's center. NaN is not.
bool IsInside(const Eigen::Vector2d& pixel, const CameraModel& camera) {
  return pixel.x() >= -0.5 && pixel.y() >= -0.5 && pixel.x() < camera.width - 0.5 &&
         pixel.y() < camera.height - 0.5;
}

// Eight bytes, as numbers.
[[gnu::always_inline]] inline void Load(const uint8_t* from, Words* numbers) {
  Bytes bytes = {};
  std::memcpy(&bytes, from, 8);
  bytes = __builtin_shufflevector(
      bytes, Bytes{}, 0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
  std::memcpy(numbers, &bytes, sizeof(Words));
}

}  // namespace

std::vector<int32_t> UndistortionMap(const CameraIntrinsics& intrinsics) {
  const CameraModel& camera = intrinsics.camera;
  std::vector<int32_t> map;
  map.reserve(static_cast<size_t>(camera.width) * static_cast<size_t>(camera.height));
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector2d shown = DistortedPixel(intrinsics, u, v);
      map.push_back(IsInside(shown, camera)
                        ? static_cast<int32_t>(std::floor(shown.y() + 0.5)) * camera.width +
                              static_cast<int32_t>(std::floor(shown.x() + 0.5))
                        : -1);
    }
  }
  return map;
}

std::vector<uint16_t> Undistort(std::span<const uint16_t> depth, std::span<const int32_t> map) {
  VANTAGE_CHECK(depth.size() == map.size(), "an undistortion map of another size");
  std::vector<uint16_t> ideal(map.size(), 0);
  for (size_t i = 0; i < map.size(); ++i) {
    if (map[i] >= 0) ideal[i] = depth[static_cast<size_t>(map[i])];
  }
  return ideal;
}

ImageUndistortion::ImageUndistortion(const CameraIntrinsics& intrinsics)
    : width_(static_cast<size_t>(intrinsics.camera.width)) {
  const CameraModel& camera = intrinsics.camera;
  map_.reserve(width_ * static_cast<size_t>(camera.height));
  const auto share = [](double part) { return static_cast<uint16_t>(std::lround(part * kWhole)); };
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector2d shown = DistortedPixel(intrinsics, u, v);
      if (!IsInside(shown, camera)) {
        map_.push_back({-1, 0, 0});
        continue;
      }
      // On the last column or row nothing to the right or below has a share.
      const double x = std::clamp(shown.x(), 0.0, camera.width - 1.0);
      const double y = std::clamp(shown.y(), 0.0, camera.height - 1.0);
      const double left = std::floor(x);
      const double top = std::floor(y);
      map_.push_back({static_cast<int32_t>(top) * camera.width + static_cast<int32_t>(left),
                      share(x - left),
                      share(y - top)});
    }
  }
}

void ImageUndistortion::Undistort(int channels, std::vector<uint8_t>* pixels) {
  VANTAGE_CHECK(channels == 1 || channels == 3, "gray or RGB");
  const size_t step = static_cast<size_t>(channels);
  VANTAGE_CHECK(pixels->size() == step * map_.size(), "an image of another size");
  // One row and eight bytes more, so that what has no share can be read.
  distorted_.resize(pixels->size() + step * width_ + 8);
  std::ranges::copy(*pixels, distorted_.begin());
  if (channels == 3) {
    MixRgb(pixels->data());
  } else {
    MixGray(pixels->data());
  }
}

void ImageUndistortion::MixGray(uint8_t* ideal) const {
  for (const Source& source : map_) {
    uint32_t mixed = 0;
    if (source.place >= 0) {
      const uint8_t* top = distorted_.data() + source.place;
      const uint8_t* bottom = top + width_;
      const uint32_t left = kWhole - source.right;
      const uint32_t above = top[0] * left + top[1] * uint32_t{source.right};
      const uint32_t below = bottom[0] * left + bottom[1] * uint32_t{source.right};
      mixed = above * (kWhole - source.down) + below * source.down + kWhole * kWhole / 2;
    }
    *ideal++ = static_cast<uint8_t>(mixed / (kWhole * kWhole));
  }
}

// Three channels at once: eight bytes reach from a pixel to its right neighbor.
VANTAGE_SIMD void ImageUndistortion::MixRgb(uint8_t* ideal) const {
  for (const Source& source : map_) {
    uint32_t mixed = 0;
    if (source.place >= 0) {
      const uint8_t* top = distorted_.data() + 3 * static_cast<size_t>(source.place);
      const uint16_t up = static_cast<uint16_t>(kWhole - source.down);
      const uint16_t left = static_cast<uint16_t>(kWhole - source.right);
      Words above;
      Words below;
      Load(top, &above);
      Load(top + 3 * width_, &below);
      // At most 255 * 256 + 128, which 16 bits hold.
      const Words column = (above * up + below * source.down + 128) >> 8;
      const Words next = __builtin_shufflevector(column, column, 3, 4, 5, 3, 3, 4, 5, 3);
      const Words both = (column * left + next * source.right + 128) >> 8;
      Bytes bytes;
      std::memcpy(&bytes, &both, sizeof(Bytes));
      bytes = __builtin_shufflevector(
          bytes, bytes, 0, 2, 4, 6, 8, 10, 12, 14, 0, 2, 4, 6, 8, 10, 12, 14);
      std::memcpy(&mixed, &bytes, sizeof(mixed));
    }
    std::memcpy(ideal, &mixed, 3);
    ideal += 3;
  }
}

}  // namespace vantage
