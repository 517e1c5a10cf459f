#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "common/result.h"
#include "tools/support/recorded_view.h"

namespace vantage {

/// True when the folder is a scene of a BOP data set (it has scene_camera.json), or has scenes in
/// it.
bool IsBopFolder(const std::filesystem::path& folder);

/// Views in order of their numbers of one scene in the format of the BOP benchmark (Hodan et al.
/// 2018): scene_camera.json with cam_K, depth_scale (mm), cam_R_w2c and cam_t_w2c (mm) for each
/// image, and depth/NNNNNN.png.
/// @param folder the scene, or a folder of scenes named by their numbers.
/// @param scene which scene; needed when there are several.
/// @param depth_scale takes the place of the files' own, mm for a value of 1.
/// Errors: no such scene, no JSON, JSON of another shape, an image without camera pose or depth,
/// matrices that are not finite or far from a rotation, a camera beyond 10 km.
Result<std::vector<RecordedView>> ListBopScene(const std::filesystem::path& folder,
                                               std::optional<int> scene,
                                               std::optional<double> depth_scale);

}  // namespace vantage
