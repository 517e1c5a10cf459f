#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/so3.h"
#include "tools/evaluate/dataset.h"
#include "tools/evaluate/dataset_estimator.h"
#include "tools/evaluate/pose_success.h"

namespace vantage {

/// What an estimator is given of a view.
enum class DatasetSearch {
  kWholeImage,  ///< the image, and all models of the dataset
  kSegment,     ///< the pixels that are the object's, and its model
};

/// "whole image", "segment".
std::string Name(DatasetSearch search);

/// One object of one view, looked for by one estimator.
struct DatasetOutcome {
  size_t dataset = 0;  ///< in DatasetResults::datasets
  size_t view = 0;     ///< in Dataset::views
  size_t object = 0;   ///< in DatasetView::objects
  std::string estimator;
  DatasetSearch search = DatasetSearch::kSegment;

  bool is_found = false;  ///< the rest up to score is of the best detection of the model
  Pose T_camera_object = Pose::Identity();
  PoseSuccess success;
  double angle_other = 0.0;     ///< rad, to the other truth; NaN where there is none
  double distance_other = 0.0;  ///< m, likewise
  double score = 0.0;           ///< [0, 1], of verification

  double truth_offset = 0.0;  ///< m, median of measured to true surface; NaN: not in view
  int num_clusters = 0;       ///< of the image
  int num_wrong = 0;     ///< detections in the image that are right for no object of their model
  double seconds = 0.0;  ///< for the image, likewise
  StageSeconds stages;
};

/// All outcomes of one dataset, estimator and search.
struct DatasetSummary {
  size_t dataset = 0;
  std::string estimator;
  DatasetSearch search = DatasetSearch::kSegment;
  int num_objects = 0;
  int num_found = 0;
  int num_within = 0;             ///< of those found
  int num_indistinguishable = 0;  ///< of those found
  int num_succeeded = 0;          ///< one or both of these
  int num_wrong = 0;              ///< detections, each image counted once
  double median_angle = 0.0;      ///< rad, of those found; NaN where none was
  double largest_angle = 0.0;     ///< rad, likewise
  double median_distance = 0.0;   ///< m, likewise
  double median_seconds = 0.0;    ///< of an image
  double largest_seconds = 0.0;   ///< of an image
};

/// All that the report shows.
struct DatasetResults {
  std::string command;  ///< that makes it again
  std::string version;  ///< of the program
  uint64_t seed = 0;
  PoseSuccessParameters bounds;  ///< of success
  std::vector<Dataset> datasets;
  std::vector<std::string> notes;  ///< folders that were passed over, a sentence each
  std::vector<DatasetOutcome> outcomes;
};

/// In the outcomes' order.
std::vector<DatasetSummary> Summarize(const DatasetResults& results);

/// The datasets' bars that are not met, a sentence each.
std::vector<std::string> MissedBars(const DatasetResults& results);

}  // namespace vantage
