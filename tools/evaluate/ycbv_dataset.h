#pragma once

#include <filesystem>

#include "common/result.h"
#include "tools/evaluate/dataset.h"

namespace vantage {

/// True when the folder has a file NNNNNN-meta.json.
bool IsYcbvDataset(const std::filesystem::path& folder);

/// Cluttered frames of YCB-Video (Xiang et al., "PoseCNN", RSS 2018):
///   N-depth.png   16 bits, unit 1 / factor_depth m
///   N-label.png   8 bits, class of each pixel
///   N-meta.json   intrinsic_matrix, factor_depth, objects with cls_index, name and
///                 camera_T_model_3x4 (m), the model being models/NAME/points.xyz
/// Models are the YCB scans in `meshes`, which have another frame: it is found by aligning
/// points.xyz with the scan. Objects without a scan there are left out, with a note.
/// Errors name the file that is absent, damaged or of another shape, or whose points do not lie on
/// the scan.
Result<Dataset> LoadYcbvDataset(const std::filesystem::path& folder,
                                const std::filesystem::path& meshes);

}  // namespace vantage
