#pragma once

#include "common/camera_model.h"
#include "common/lens_distortion.h"

namespace vantage {

/// How a real camera maps lines of sight to pixels: its lens, then a pinhole camera.
struct CameraIntrinsics {
  CameraModel camera;
  LensDistortion distortion;

  bool operator==(const CameraIntrinsics&) const = default;
};

}  // namespace vantage
