#pragma once

#include <filesystem>
#include <vector>

#include "common/camera_model.h"
#include "common/result.h"
#include "common/so3.h"
#include "tools/support/recorded_view.h"

namespace vantage {

/// True when the folder, or one folder in it, has depth images named as a view folder's.
bool IsViewFolder(const std::filesystem::path& folder);

/// Views in order of their numbers of a folder with
///   depth_N.png               and world_T_camera_N.txt, or
///   frame-N.depth.png         and frame-N.pose.txt,
/// in the folder or in one folder in it, and with Intrinsic.txt or camera-intrinsics.txt (3x3).
/// Poses are camera to world, 4x4, m; rotations are brought to the nearest true one.
/// @param depth_scale mm for a value of 1 in the images.
/// Errors: no depth images, no intrinsics, a view without a pose, matrices of another shape, that
/// are not finite, or far from a rotation.
Result<std::vector<RecordedView>> ListViewFolder(const std::filesystem::path& folder,
                                                 double depth_scale);

/// A rigid transform as 4x4 numbers. Errors as ListViewFolder's for a pose.
Result<Pose> ReadPoseFile(const std::filesystem::path& file);

/// fx, fy, cx, cy of a 3x3 matrix of intrinsics. Errors: another shape, a skew, not positive.
Result<CameraModel> ReadIntrinsicsFile(const std::filesystem::path& file);

}  // namespace vantage
