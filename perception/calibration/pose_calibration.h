#pragma once

#include <cstdint>
#include <span>

#include "common/result.h"
#include "perception/calibration/hand_eye.h"
#include "perception/calibration/hand_trajectory.h"

namespace vantage {

struct PoseCalibrationOptions {
  HandEyeNoise noise;
  bool estimate_robot_scale = false;
  /// Asks for the time offset, for which the views need utimes; null: it is taken as 0. Outlives
  /// the call.
  const HandTrajectory* trajectory = nullptr;
  uint64_t seed = 1;  ///< of the search for views that agree
};

/// Calibrates from poses of the target: a closed form on views that agree (FindConsensus()), then
/// all of them in one least-squares problem whose residuals are whitened by the noise of robot and
/// camera; outliers are left out. What the motions don't fix is no error: see
/// HandEyeResult::observability. Errors: fewer than 3 views, or poses that are not finite; no three
/// views agree; no utimes or no trajectory about them where the time offset is asked for.
Result<HandEyeResult> CalibrateFromPoses(HandEyeSetup setup,
                                         std::span<const PoseView> views,
                                         const PoseCalibrationOptions& options);

}  // namespace vantage
