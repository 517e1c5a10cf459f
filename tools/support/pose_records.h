#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "common/result.h"

namespace vantage {

/// One estimate of the pose of an object in one view, as pose_comparison writes it.
struct PoseRecord {
  std::string model;
  std::string estimator;
  int view = 0;          ///< of the model; the same for all estimators
  bool is_peer = false;  ///< Other people's estimator.
  double ms = 0.0;       ///< for the whole estimate
  std::map<std::string, double> stages_ms;
  bool is_within = false;    ///< of the truth modulo symmetry, by 5 deg and 5 % of the diameter
  bool is_success = false;   ///< within, or indistinguishable from the truth in that view
  double angle_deg = 0.0;    ///< to the truth modulo symmetry; 0 where nothing was found
  double distance_mm = 0.0;  ///< of the centers
};

/// Reads JSON lines and appends them. Errors name file and line: absent, not JSON, a field absent
/// or of another type, a time that is not positive, within without success.
Result<void> ReadPoseRecords(const std::filesystem::path& file, std::vector<PoseRecord>* records);

}  // namespace vantage
