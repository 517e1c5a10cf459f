#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "common/result.h"
#include "nodes/config_reader.h"
#include "perception/calibration/calibration_target.h"
#include "perception/calibration/drift_check.h"
#include "perception/calibration/hand_eye.h"
#include "perception/calibration/hand_pose_candidates.h"

namespace vantage {

/// How `vantage-handeye live` goes about it: table [extrinsics.live].
struct LiveCalibrationParameters {
  double first_turn = 15.0 * kDegree;      ///< rad, of the first motions, in place
  HandPoseLimits limits;                   ///< of all motions, from the start
  double translation_bound = 0.0003;       ///< m, of the 95 % ellipsoid's half axes: good enough
  double rotation_bound = 0.03 * kDegree;  ///< rad
  int least_views = 8;
  int max_views = 30;
  double patience_s = 20.0;  ///< s, for the robot to arrive and be seen; then another pose
};

/// A camera's extrinsics: tables [extrinsics], [extrinsics.base], [extrinsics.target],
/// [extrinsics.check] and [extrinsics.live].
struct ExtrinsicsConfig {
  std::string camera = "XTION";  ///< the <NAME> of CAMERA_<NAME>
  HandEyeSetup setup = HandEyeSetup::kEyeInHand;
  std::filesystem::path calibration;  ///< file of nodes/handeye_file.h
  std::string hand_channel = "HAND_TO_BASE";
  Pose T_world_base = Pose::Identity();
  std::optional<CalibrationTarget> target;   ///< nothing: object detections alone are looked at
  std::string detections = "DETECTIONS_.*";  ///< channels; empty: none
  double detection_sigma = 0.003;            ///< m, of an object's position in a detection
  HandEyeNoise noise;
  DriftCheckParameters check;
  LiveCalibrationParameters live;
};

Result<ExtrinsicsConfig> ReadExtrinsicsConfig(ConfigReader& config);

}  // namespace vantage
