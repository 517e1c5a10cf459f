#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "common/camera_model.h"
#include "common/depth_image.h"
#include "common/result.h"

namespace vantage {

/// One depth image of a log as an estimator gets it.
struct StageImage {
  int64_t utime = 0;  ///< us
  DepthImage depth;
  CameraModel camera;
  int number = 0;  ///< counts the images taken at rest, from 1
  int count = 0;   ///< of these in the log
};

/// Reads CAMERA_<camera>, _INFO and _TO_WORLD. Images count that were taken while the camera
/// rested, as estimators choose them; all when the log has no poses at all.
/// @param number from 1; nothing: the first of which DETECTIONS_* tells an object, or the first.
/// @param rest_window_s s before and after an image in which the camera rests.
/// Errors: the log; no calibration, no such image, one of another size than the calibration's.
Result<StageImage> ReadStageImage(const std::filesystem::path& log,
                                  const std::string& camera,
                                  std::optional<int> number,
                                  double rest_window_s);

}  // namespace vantage
