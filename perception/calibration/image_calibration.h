#pragma once

#include <cstdint>
#include <span>

#include "common/result.h"
#include "perception/calibration/hand_eye.h"
#include "perception/calibration/hand_trajectory.h"

namespace vantage {

struct ImageCalibrationOptions {
  HandEyeNoise noise = {};
  bool estimate_focal_lengths = false;  ///< fx, fy, cx, cy
  bool estimate_distortion = false;     ///< k1, k2, p1, p2 (k3 stays)
  bool estimate_robot_scale = false;
  const HandTrajectory* trajectory = nullptr;  ///< asks for the time offset; outlives the call
  uint64_t seed = 1;
};

/// Calibrates from the target's points in images: poses of single views with both solutions of a
/// flat target (target_pose.h), those that agree (FindConsensus()), then one problem over X, Y,
/// what else is asked for, and the robot's poses with their noise as priors, with the reprojection
/// error of every point. How noisy points and robot are is told by the residuals; options.noise is
/// where that starts. ViewResidual::pixels is of the points where X, Y and the robot say they are.
/// Views with fewer than 4 points are listed as outliers, with zeros. Errors: fewer than 3 views
/// with 4 points, bad numbers, as CalibrateFromPoses().
Result<HandEyeResult> CalibrateFromImages(HandEyeSetup setup,
                                          std::span<const ImageView> views,
                                          const CameraModel& camera,
                                          const LensDistortion& distortion,
                                          const ImageCalibrationOptions& options);

}  // namespace vantage
