#pragma once

#include <string>

#include "common/camera_model.h"
#include "common/detection.h"
#include "common/lens_distortion.h"
#include "common/result.h"
#include "common/so3.h"
#include "vantage/camera_info_t.hpp"
#include "vantage/detections_v2_t.hpp"
#include "vantage/rigid_transform_t.hpp"

namespace vantage {

/// T_world_camera of a CAMERA_<NAME>_TO_WORLD. Errors as CheckUtime and PoseFromWire.
Result<Pose> PoseFromMessage(const rigid_transform_t& message);
/// @param utime us since the epoch at which the pose held.
rigid_transform_t PoseToMessage(const Pose& T_world_camera, int64_t utime);

/// Errors: as CheckUtime and CameraModel::Validate(), a depth unit other than 0.001 m, or a
/// distortion that the pinhole model can't follow (its model is not "none" and some coefficient is
/// not 0).
Result<CameraModel> CameraFromMessage(const camera_info_t& message);
/// What says who the camera is, beside its geometry.
struct CameraIdentity {
  std::string name;            ///< the <NAME> of the channels
  std::string serial;          ///< of the device; empty if it has none
  std::string frame;           ///< name of the optical frame
  bool registered = false;     ///< depth lies in the colour camera's frame
  std::string calibration_id;  ///< where the intrinsics come from
};
/// Depth unit 0.001 m. @param seq counts messages of the channel. @param distortion left in the
/// images, which CameraFromMessage() then refuses.
camera_info_t CameraToMessage(const CameraModel& camera,
                              const CameraIdentity& identity,
                              int64_t utime,
                              int64_t seq,
                              const LensDistortion& distortion = {});

/// Errors: as CheckUtime, names with other characters than letters, digits, '_', '-', '.' or longer
/// than 64, no model id, more than 10,000 detections, poses as PoseFromWire, negative counts or
/// indices, values that are not finite or out of range. `channel` goes into the result.
Result<DetectionSet> DetectionsFromMessage(const detections_v2_t& message,
                                           const std::string& channel);
detections_v2_t DetectionsToMessage(const DetectionSet& set);

}  // namespace vantage
