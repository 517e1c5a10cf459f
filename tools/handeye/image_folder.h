#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/result.h"
#include "perception/calibration/raw_pose.h"

namespace vantage {

/// Where a folder keeps its images and the robot's poses.
struct ImageFolderLayout {
  std::filesystem::path folder;
  /// "%d" stands for a number: image-%d.png; with pose_pattern.
  std::string image_pattern = {};
  /// A file with the pose T_base_hand of the image of that number: 6 numbers (translation, rotation
  /// vector) or 16 (a matrix), as plain text or in the YAML of ViSP. Empty: the table poses.csv in
  /// the folder with columns image and hand_... .
  std::string pose_pattern = {};
};

/// An image and where the hand was.
struct FolderImage {
  std::filesystem::path file;
  int64_t utime = 0;  ///< us since the epoch; 0: not known
  RawPose hand;
};

/// In the order of the table, or of the numbers. Errors: absent, a pattern without %d, no image
/// that fits, an image without a pose, files that hold something else.
Result<std::vector<FolderImage>> ReadImageFolder(const ImageFolderLayout& layout);

}  // namespace vantage
