#pragma once

#include <filesystem>

#include "common/result.h"
#include "tools/evaluate/dataset.h"

namespace vantage {

/// True when the folder has milk.pcd.
bool IsSceneCropDataset(const std::filesystem::path& folder);

/// The scene of PCL's tutorial on correspondence grouping and the model that was cut out of it:
/// milk.pcd, and beside it one organised point cloud of a Kinect (fx = fy = 525, center 319.5,
/// 239.5). The points of the model are those of the scene, moved: the pose is exact. The model's
/// surface is made by joining neighboring pixels. As the model is the very view that it is looked
/// for in, this shows that the parts fit, not how accurate they are.
/// Errors name the file that is absent, damaged or of another shape, points that are not on their
/// pixels' lines of sight, and a model that is not of the scene.
Result<Dataset> LoadSceneCropDataset(const std::filesystem::path& folder);

}  // namespace vantage
