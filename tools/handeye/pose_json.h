#pragma once

#include <filesystem>
#include <vector>

#include "common/result.h"
#include "perception/calibration/raw_pose.h"

namespace vantage {

/// Pairs of poses in JSON: {"views": [{"hand": POSE, "camera": POSE, "name": TEXT, "utime": US}]}
/// with POSE {"position_m": [3], "quaternion_wxyz": [4]}, or "rotation_vector_rad": [3] instead of
/// the quaternion, or {"matrix": [4][4]}; or MoveIt's pose_samples.json, [[[4][4], [4][4]], ...] of
/// base_T_eef and camera_T_target. Errors: absent, larger than 64 MiB, no JSON (with the place),
/// nested deeper than that, fields that are missing, unknown or no numbers.
Result<std::vector<RawView>> ReadPoseJson(const std::filesystem::path& file);

}  // namespace vantage
