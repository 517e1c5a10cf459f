#pragma once

#include <cstdint>
#include <filesystem>

#include "common/camera_model.h"
#include "common/so3.h"

namespace vantage {

/// One depth image that somebody recorded, with where its camera was. The camera's size in pixels
/// is that of the image and not known before it is read.
struct RecordedView {
  int64_t number = 0;                      ///< In the files' names.
  std::filesystem::path depth_file;        ///< 16-bit grey PNG
  double depth_scale = 1.0;                ///< mm for a value of 1 in the image
  CameraModel camera;                      ///< Only fx, fy, cx, cy.
  Pose T_world_camera = Pose::Identity();  ///< m
};

}  // namespace vantage
