#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/camera_intrinsics.h"

namespace vantage {

/// For every pixel of the image that an ideal pinhole camera would take, row by row, the pixel of
/// the distorted image nearest to where its ray falls; -1: beside the image.
std::vector<int32_t> UndistortionMap(const CameraIntrinsics& intrinsics);

/// The ideal image, 0 where the map says -1. Depths are not mixed: that would invent surfaces
/// between near and far ones. `depth` and `map` have the same size.
std::vector<uint16_t> Undistort(std::span<const uint16_t> depth, std::span<const int32_t> map);

/// The same for color and gray images, between whose pixels is interpolated.
class ImageUndistortion {
 public:
  explicit ImageUndistortion(const CameraIntrinsics& intrinsics);

  /// From the distorted image to the ideal one, 0 beside it.
  /// @param pixels rows one after the other, 1 or 3 `channels` of a byte each.
  void Undistort(int channels, std::vector<uint8_t>* pixels);

 private:
  // The four pixels right of and below `place` lie around the ray; their shares are in 1/256.
  struct Source {
    int32_t place;  // -1: beside the image
    uint16_t right;
    uint16_t down;
  };

  void MixGray(uint8_t* ideal) const;
  void MixRgb(uint8_t* ideal) const;

  size_t width_;
  std::vector<Source> map_;
  std::vector<uint8_t> distorted_;  // Reused: the image, and some more to read on into.
};

}  // namespace vantage
