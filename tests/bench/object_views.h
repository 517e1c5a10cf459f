#pragma once

#include <cstdint>
#include <vector>

#include "common/camera_model.h"
#include "common/depth_image.h"
#include "common/so3.h"
#include "perception/model/object_model.h"

namespace vantage {

/// An object that floats alone before the simulated sensor: every pixel that measures is of it.
struct ObjectView {
  CameraModel camera;
  DepthImage depth;
  Pose T_camera_object = Pose::Identity();
  double visible_share = 0.0;  ///< of the object's surface, that the camera sees
};

/// Views of a model, orientation uniform over SO(3), 0.6 to 0.9 m from the camera (farther where an
/// object of over 0.2 m would not fit into the image), with all of the structured noise of
/// SensorModel, each of another device. The same for equal arguments.
std::vector<ObjectView> MakeObjectViews(const ObjectModel& model, int count, uint64_t seed);

}  // namespace vantage
