#pragma once

#include <cstdint>
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

/// SurfaceSampler::Sample of one segment alone; slower.
std::vector<SurfacePoint> SampleSurfaces(const DepthImage& depth,
                                         const CameraModel& camera,
                                         std::span<const int32_t> labels,
                                         std::span<const uint32_t> pixels,
                                         double spacing,
                                         const NormalParameters& parameters);

}  // namespace vantage
