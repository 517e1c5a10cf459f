#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/result.h"
#include "perception/calibration/calibration_target.h"
#include "perception/calibration/hand_eye.h"
#include "perception/calibration/input_mistakes.h"
#include "tools/handeye/calibration_input.h"

namespace vantage {

/// What may be estimated beside the poses.
enum class Estimated { kIntrinsics, kDistortion, kRobotScale, kTimeOffset };

struct HandEyeRunOptions {
  HandEyeSetup setup = HandEyeSetup::kEyeInHand;
  HandEyeNoise noise;
  std::set<Estimated> estimated;
  uint64_t seed = 1;
};

/// A pose that the hand had better go to next.
struct SuggestedPose {
  Pose T_base_hand = Pose::Identity();
  double sigma_now = 0.0;    ///< m, as NextPose::expected_sigma
  double sigma_after = 0.0;  ///< m
};

/// A calibration and all that is to be said of it.
struct HandEyeRun {
  HandEyeResult result;
  InputDiagnosis diagnosis;
  /// Why it must not be used, a sentence each; empty: it may.
  std::vector<std::string> refusals;
  std::vector<std::string> warnings;
  std::optional<SuggestedPose> next;
};

/// Calibrates and judges. Errors: what was asked for does not go with the input; as
/// CalibrateFromPoses() and CalibrateFromImages(), with the mistake in the input where one is seen.
Result<HandEyeRun> RunHandEye(const CalibrationInput& input,
                              const HandEyeRunOptions& options,
                              const std::optional<CalibrationTarget>& target);

/// The best of poses about `T_base_hand`; nothing where none of them shows the whole target.
std::optional<SuggestedPose> SuggestPose(const HandEyeResult& result,
                                         const Pose& T_base_hand,
                                         const CameraModel& camera,
                                         const std::optional<CalibrationTarget>& target,
                                         const HandEyeNoise& noise);

}  // namespace vantage
