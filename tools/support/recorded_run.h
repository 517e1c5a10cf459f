#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/camera_model.h"
#include "common/depth_image.h"
#include "common/detection.h"
#include "common/result.h"
#include "common/so3.h"
#include "vantage/next_view_t.hpp"
#include "vantage/object_estimates_v3_t.hpp"
#include "vantage/orientation_histogram_t.hpp"

namespace vantage {

/// What happened at one viewpoint of a run.
struct RunView {
  int64_t utime = 0;  ///< us, of the image that stands for it; 0: the log does not tell
  Pose T_world_camera = Pose::Identity();  ///< at utime
  DepthImage depth;                        ///< that image; empty when the log has none
  std::map<int32_t, Pose> detections;      ///< T_world_object by instance id: this view alone
  object_estimates_v3_t objects{};         ///< the fused estimates after it
  std::map<int32_t, orientation_histogram_t> histograms;  ///< by instance id, after it
  next_view_t next_view{};                                ///< NEXT_VIEW after it
};

/// A run as its log tells it.
struct RecordedRun {
  std::optional<CameraModel> camera;
  std::vector<RunView> views;  ///< by viewpoint
  bool finished = false;       ///< OBJECTS said so
  std::string damage;          ///< of the log, in words; empty: none
};

/// Reads OBJECTS, DETECTIONS_*, ORIENTATION_HISTOGRAM, NEXT_VIEW and CAMERA_<camera>* of a log.
/// Messages that fail their checks are left out. Where fusion was started anew, what was before is
/// no part of the run. Errors: the log; no OBJECTS in it.
Result<RecordedRun> ReadRun(const std::filesystem::path& log, const std::string& camera);

/// T_world_object of the first peak of an estimate; nothing when it has none or it is invalid.
std::optional<Pose> EstimatedPose(const object_estimate_v3_t& object);

/// T_world_object refined on the depth of all views; nothing when it was not or it is invalid.
std::optional<Pose> RefinedPose(const object_estimate_v3_t& object);

}  // namespace vantage
