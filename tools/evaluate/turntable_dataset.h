#pragma once

#include <filesystem>

#include "common/result.h"
#include "tools/evaluate/dataset.h"

namespace vantage {

/// True when the folder has camera_T_model.csv.
bool IsTurntableDataset(const std::filesystem::path& folder);

/// One object on a turntable, segmented depth images:
///   Intrinsic.txt       3x3
///   depth_NN.png        16 bits, mm
///   camera_T_model.csv  a header, then a line a view: its number, the upper 3x4 of its pose by
///                       markers, and the same refined on the view's own depth, which is the truth
///                       here, the markers' the other one
/// of meshes/stanford_bunny.ply. Errors name the file that is absent, damaged or of another shape.
Result<Dataset> LoadTurntableDataset(const std::filesystem::path& folder,
                                     const std::filesystem::path& meshes);

}  // namespace vantage
