#include "drivers/camera/undistortion.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "common/check.h"
#include "common/simd.h"
#include "drivers/camera/bilinear.h"

namespace vantage {
namespace {

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
  const auto share = [](double part) {
    return static_cast<uint16_t>(std::lround(part * bilinear::kWhole));
  };
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
    *ideal++ =
        source.place < 0
            ? uint8_t{0}
            : bilinear::Gray(distorted_.data() + source.place, width_, source.right, source.down);
  }
}

VANTAGE_SIMD void ImageUndistortion::MixRgb(uint8_t* ideal) const {
  for (const Source& source : map_) {
    if (source.place >= 0) {
      const uint8_t* top = distorted_.data() + 3 * static_cast<size_t>(source.place);
      bilinear::Rgb(top, 3 * width_, source.right, source.down, ideal);
    } else {
      std::memset(ideal, 0, 3);
    }
    ideal += 3;
  }
}

}  // namespace vantage
