#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "common/camera_model.h"
#include "common/lens_distortion.h"
#include "common/result.h"
#include "perception/calibration/hand_eye.h"

namespace vantage {

/// A hand-eye calibration as a TOML file keeps it (docs/calibration.md).
struct HandEyeFile {
  std::string camera = "CAMERA";  ///< the <NAME> of the camera's channels
  HandEyeSetup setup = HandEyeSetup::kEyeInHand;
  int64_t created_utime = 0;  ///< us since the epoch: of the last view used; 0: not known

  Pose T_x = Pose::Identity();                               ///< T_hand_camera or T_base_camera
  HandEyeCovariance covariance = HandEyeCovariance::Zero();  ///< of X, as in HandEyeResult
  Pose T_y = Pose::Identity();                               ///< T_base_target or T_hand_target
  HandEyeCovariance target_covariance = HandEyeCovariance::Zero();  ///< of Y, alike
  HandEyeCovariance cross_covariance = HandEyeCovariance::Zero();   ///< of X's errors with Y's
  double squared_radius_95 = 12.592;                                ///< as in HandEyeResult
  double noise_scale = 1.0;                                         ///< as in HandEyeResult

  int num_views = 0;             ///< used
  int num_outliers = 0;          ///< left out
  double rotation_rms = 0.0;     ///< rad, over the views used
  double translation_rms = 0.0;  ///< m
  double pixel_rms = 0.0;        ///< px; 0 without images

  double robot_scale = 1.0;               ///< true length by length that the robot tells
  double time_offset = 0.0;               ///< s; the image of utime t shows the hand of t + offset
  std::optional<CameraModel> intrinsics;  ///< those that the calibration was made with, or found
  LensDistortion distortion;              ///< none without intrinsics
};

/// @param utime us since the epoch, of the last view used; 0: not known.
HandEyeFile MakeHandEyeFile(const HandEyeResult& result, const std::string& camera, int64_t utime);

/// TOML with comments that tell units; the same calibration gives the same text, and reading it
/// gives every number back exactly (rotations: to rounding).
std::string HandEyeFileText(const HandEyeFile& calibration);

/// Writes the file whole or not at all: beside it, then renamed. Errors: the system refuses.
Result<void> WriteHandEyeFile(const HandEyeFile& calibration, const std::filesystem::path& file);

/// Errors: absent, larger than 1 MiB, no TOML (with line and column); keys that are missing or
/// unknown; values out of range (with file, line, key, value and bound): quaternions that are not
/// of unit length, covariances that are none, names that are not of a channel.
Result<HandEyeFile> ReadHandEyeFile(const std::filesystem::path& file);

/// The same of a text; `name` stands for the file in messages.
Result<HandEyeFile> ParseHandEyeFile(const std::string& text, const std::string& name);

}  // namespace vantage
