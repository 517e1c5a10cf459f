#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/camera_model.h"
#include "common/depth_image.h"
#include "common/result.h"
#include "common/triangle_mesh.h"
#include "perception/depth_noise.h"

namespace vantage {

struct NormalParameters {
  double radius = 0.007;  ///< m, half the window's side; 3 to 4 times the sensor's depth step
  int min_radius_px = 2;
  int max_radius_px = 10;
  double min_share = 0.25;  ///< of the window that must lie on the same surface
  DepthNoise noise;
  Result<void> Validate() const;
};

/// The surface at a pixel: a plane fitted to inverse depth, which is affine in the image on a plane
/// and in which the steps of a structured-light camera have one size. Neighbors of another label or
/// across a depth discontinuity are left out. The position lies on the line of sight of the pixel.
/// Nothing when too few neighbors are left.
std::optional<SurfacePoint> SurfaceAt(const DepthImage& depth,
                                      const CameraModel& camera,
                                      std::span<const int32_t> labels,
                                      uint32_t pixel,
                                      const NormalParameters& parameters);

/// SurfaceAt about one pixel of every cube of `spacing` m that holds some of `pixels`: the one
/// nearest to the mean of those in the cube. In the order of the cubes' first pixels.
std::vector<SurfacePoint> SampleSurfaces(const DepthImage& depth,
                                         const CameraModel& camera,
                                         std::span<const int32_t> labels,
                                         std::span<const uint32_t> pixels,
                                         double spacing,
                                         const NormalParameters& parameters);

}  // namespace vantage
