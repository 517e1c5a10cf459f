#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/camera_intrinsics.h"
#include "common/so3.h"
#include "drivers/camera/depth_registration.h"
#include "drivers/camera/ray_projection.h"

namespace vantage {

/// Color images as the depth camera would have taken them, where it measured a depth.
class ColorRegistration {
 public:
  /// @param depth an ideal camera, that of undistorted depth images
  /// @param color of the color images as they will be given
  ColorRegistration(const CameraModel& depth,
                    const CameraIntrinsics& color,
                    const Pose& T_color_depth);

  /// @param depth_mm row by row along the depth camera's axis, 0: no measurement
  /// @param pixels rows one after the other, 1 or 3 `channels` of a byte each
  /// @param registered gets the depth camera's size, the colors interpolated. 0 without a
  /// measurement, beside the color image, and where something nearer hides the point from the color
  /// camera.
  void Register(std::span<const uint16_t> depth_mm,
                int channels,
                std::span<const uint8_t> pixels,
                std::vector<uint8_t>* registered);

 private:
  // From the ideal color image to the one given, px.
  struct Shift {
    float u, v;
  };

  void RegisterRow(size_t channels, uint8_t* registered) const;

  CameraModel color_;
  RayProjection projection_;
  DepthRegistration to_color_;
  std::vector<Shift> shifts_;      // Of every pixel of the ideal color image; empty: none.
  std::vector<uint16_t> seen_mm_;  // By the ideal color camera.
  std::vector<uint8_t> pixels_;    // The color image, and some more to read on into.
  std::vector<float> u_;           // A row's places in the ideal color image, as what follows.
  std::vector<float> v_;
  std::vector<float> z_;
};

}  // namespace vantage
