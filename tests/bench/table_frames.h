#pragma once

#include <vector>

#include "common/camera_model.h"
#include "common/depth_image.h"
#include "common/so3.h"

namespace vantage {

/// A filter, a mug and a bracket on a table over a floor, as the simulated sensor sees them.
struct TableFrame {
  CameraModel camera;
  std::vector<Pose> T_camera_object;
  DepthImage depth;
};

/// VGA frame `number` of a camera that goes round the table at 0.75 m. Equal numbers, equal frames.
TableFrame MakeTableFrame(int number);

}  // namespace vantage
