#include "tools/evaluate/dataset.h"

#include <algorithm>
#include <system_error>

#include "common/format.h"
#include "tools/evaluate/scene_crop_dataset.h"
#include "tools/evaluate/turntable_dataset.h"
#include "tools/evaluate/ycbv_dataset.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

constexpr const char* kExpected =
    "camera_T_model.csv (turntable), NNNNNN-meta.json (YCB-Video) or milk.pcd (PCL's scene)";

// A shelf of the Amazon Picking Challenge as recorded by a robot.
bool IsShelf(const fs::path& folder) {
  std::error_code error;
  return fs::exists(folder / "cam.info.txt", error) && fs::exists(folder / "final_pose.txt", error);
}

bool IsKnown(const fs::path& folder) {
  return IsTurntableDataset(folder) || IsYcbvDataset(folder) || IsSceneCropDataset(folder) ||
         IsShelf(folder);
}

Error NotKnown(const fs::path& folder) {
  return Error{ErrorCode::kNotFound,
               Format("%s is no dataset and has none in it, expected a folder with %s",
                      folder.c_str(),
                      kExpected)};
}

std::string NameOf(const fs::path& folder) {
  std::error_code error;
  const fs::path whole = fs::weakly_canonical(folder, error);
  return error ? folder.filename().string() : whole.filename().string();
}

}  // namespace

Result<std::vector<fs::path>> FindDatasets(const fs::path& folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    return Error{ErrorCode::kNotFound,
                 Format("%s is no folder, expected one with %s", folder.c_str(), kExpected)};
  }
  if (IsKnown(folder)) return std::vector<fs::path>{folder};
  std::vector<fs::path> found;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (entry.is_directory(error) && IsKnown(entry.path())) found.push_back(entry.path());
  }
  std::sort(found.begin(), found.end());
  if (found.empty()) return NotKnown(folder);
  return found;
}

std::optional<std::string> WhyNotEvaluated(const fs::path& folder) {
  if (!IsShelf(folder)) return std::nullopt;
  return Format(
      "%s has no exact ground truth (final_pose.txt is an estimate by its author), so "
      "nothing can be measured against it",
      folder.c_str());
}

Result<Dataset> LoadDataset(const fs::path& folder, const fs::path& meshes) {
  if (const std::optional<std::string> why = WhyNotEvaluated(folder)) {
    return Error{ErrorCode::kUnavailable, *why};
  }
  if (!IsKnown(folder)) return NotKnown(folder);
  Result<Dataset> dataset = IsTurntableDataset(folder) ? LoadTurntableDataset(folder, meshes)
                            : IsYcbvDataset(folder)    ? LoadYcbvDataset(folder, meshes)
                                                       : LoadSceneCropDataset(folder);
  if (dataset) dataset->name = NameOf(folder);
  return dataset;
}

}  // namespace vantage
