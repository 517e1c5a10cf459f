#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/camera_model.h"

namespace vantage {

/// k1 k2 p1 p2 k3 of Brown, "Decentering distortion of lenses", 1966, with the signs and the order
/// of OpenCV: on the plane z = 1, with r^2 = x^2 + y^2,
///   x' = x (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2)
///   y' = y (1 + k1 r^2 + k2 r^4 + k3 r^6) + p1 (r^2 + 2 y^2) + 2 p2 x y
using BrownConrady = std::array<double, 5>;

/// For every pixel of the image that an ideal pinhole camera of these intrinsics would take, row by
/// row, the pixel of the distorted image nearest to where its ray falls; -1: beside the image.
std::vector<int32_t> UndistortionMap(const CameraModel& camera, const BrownConrady& distortion);

/// The ideal image, 0 where the map says -1. Depths are not mixed: that would invent surfaces
/// between near and far ones. `depth` and `map` have the same size.
std::vector<uint16_t> Undistort(std::span<const uint16_t> depth, std::span<const int32_t> map);

}  // namespace vantage
