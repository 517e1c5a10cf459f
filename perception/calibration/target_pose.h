#pragma once

#include <span>
#include <vector>

#include "common/camera_model.h"
#include "common/lens_distortion.h"
#include "common/result.h"
#include "perception/calibration/hand_eye.h"

namespace vantage {

/// A pose that explains the target's points in one image.
struct TargetPose {
  Pose T_camera_target = Pose::Identity();
  double pixel_rms = 0.0;                                        ///< px
  HandEyeCovariance covariance = HandEyeCovariance::Identity();  ///< as PoseView::covariance
};

/// The poses of a flat target (z = 0), best first: one, or two where the second one explains the
/// image about as well. Errors: fewer than 4 points, points in a line, numbers that are not finite,
/// no pose in front of the camera.
Result<std::vector<TargetPose>> FindTargetPoses(std::span<const TargetPoint> points,
                                                const CameraModel& camera,
                                                const LensDistortion& distortion,
                                                double pixel_sigma);

}  // namespace vantage
