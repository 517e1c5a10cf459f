#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/camera_model.h"
#include "common/depth_image.h"
#include "common/result.h"
#include "common/so3.h"
#include "perception/model/object_model.h"

namespace vantage {

/// An object in a view, with its true pose.
struct DatasetObject {
  size_t model = 0;  ///< in Dataset::models
  Pose T_camera_object = Pose::Identity();
  /// The same from another measurement, where there is one.
  std::optional<Pose> T_camera_object_other;
  std::vector<uint32_t> pixels;  ///< of the object, ascending; empty where not known
};

/// A depth image whose objects are known.
struct DatasetView {
  std::string name;
  CameraModel camera;
  DepthImage depth;           ///< of the camera's width and height
  bool is_segmented = false;  ///< every pixel that measures is of the one object
  std::vector<DatasetObject> objects;
};

/// Least that an estimator shall reach.
struct DatasetBars {
  int min_found = 0;                      ///< objects found, right or not
  double max_median_angle = 5 * kDegree;  ///< rad, of those found
};

/// Real views with ground truth.
struct Dataset {
  std::string name;  ///< the folder's
  std::string what;  ///< in a sentence, for people
  std::vector<ObjectModel> models;
  std::vector<DatasetView> views;
  std::vector<std::string> notes;  ///< what is left out and why, what was checked; a sentence each
  std::optional<DatasetBars> bars;
};

/// Folders that LoadDataset() knows: `folder`, or else those in it, by name.
/// Errors: no such folder, nothing in it is known; the message says what is expected.
Result<std::vector<std::filesystem::path>> FindDatasets(const std::filesystem::path& folder);

/// Why a known folder can't be evaluated, in a sentence; nothing where it can.
std::optional<std::string> WhyNotEvaluated(const std::filesystem::path& folder);

/// Reads a dataset that is recognised by what is in its folder: turntable_dataset.h,
/// ycbv_dataset.h, scene_crop_dataset.h.
/// @param meshes folder of the meshes that go with the datasets.
/// Errors: as FindDatasets(), WhyNotEvaluated(), and as the reader's.
Result<Dataset> LoadDataset(const std::filesystem::path& folder,
                            const std::filesystem::path& meshes);

}  // namespace vantage
