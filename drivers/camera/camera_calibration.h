#pragma once

#include <optional>
#include <string>

#include "common/camera_intrinsics.h"
#include "common/so3.h"

namespace vantage {

/// What was measured of a device's cameras.
struct CameraCalibration {
  CameraIntrinsics intrinsics;            ///< of depth; of color where there is no depth
  std::optional<CameraIntrinsics> color;  ///< beside depth
  std::optional<Pose> T_color_depth;      ///< only with `color`
  std::string id;                         ///< what tells it from others, for messages
};

}  // namespace vantage
