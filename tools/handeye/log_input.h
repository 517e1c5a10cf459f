#pragma once

#include <filesystem>
#include <string>

#include "common/result.h"
#include "tools/handeye/calibration_input.h"

namespace vantage {

/// What of a log a calibration is made of.
struct LogSelection {
  std::filesystem::path log;
  std::string camera;                         ///< the <NAME> of its channels
  std::string hand_channel = "HAND_TO_BASE";  ///< rigid_transform_t, T_base_hand
  /// Images of a moving hand too, as a time offset needs them.
  bool in_motion = false;
};

/// Points of a target in the images of CAMERA_<NAME> where the hand rests, one view a rest.
/// @param intrinsics nothing: those of CAMERA_<NAME>_INFO.
/// Errors: the log is absent or no log; it has no hand poses, no images, no intrinsics; the target
/// is seen in no image.
Result<CalibrationInput> InputFromLogImages(const LogSelection& selection,
                                            const CalibrationTarget& target,
                                            const std::optional<CameraIntrinsics>& intrinsics,
                                            double pixel_sigma);

/// Poses of an object in the detections of a channel where the hand rests, the best one of each
/// image. The target's frame is the model's center. An object's finite symmetry gives each view
/// further poses.
/// @param model_folder of the object.
/// Errors: as above; the model; an object that is symmetric about an axis, whose rotation no view
/// tells; no detection of it.
Result<CalibrationInput> InputFromDetections(const LogSelection& selection,
                                             const std::string& detections_channel,
                                             const std::filesystem::path& model_folder);

}  // namespace vantage
