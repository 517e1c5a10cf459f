#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "perception/model/object_model.h"
#include "tools/support/recorded_run.h"
#include "tools/support/report_setup.h"

namespace vantage {

/// How far a pose is from the truth.
struct PoseError {
  double angle = 0.0;     ///< rad, modulo the model's symmetry
  double distance = 0.0;  ///< m, between the model's centers
};

PoseError ErrorOf(const ObjectModel& model,
                  const Pose& T_world_estimate,
                  const Pose& T_world_truth);

/// One object through a run: of the truth, or, where none is known, of the final estimates.
struct ObjectHistory {
  std::string model_id;
  std::optional<int32_t> instance;  ///< Absent: the run did not find it.
  int num_views = 0;                ///< viewpoints from which it was seen
  double seconds = 0.0;             ///< from the first image to the one that it converged with
  bool converged = false;
  std::vector<std::optional<PoseError>> detected;  ///< by viewpoint, of that view alone
  std::vector<std::optional<PoseError>> fused;     ///< by viewpoint, of all views so far
  std::vector<std::optional<PoseError>> refined;   ///< by viewpoint, on the depth of all of them

  /// After the last view; absent without truth or estimate.
  [[nodiscard]] std::optional<PoseError> final_error() const;
  /// The same of the refined pose.
  [[nodiscard]] std::optional<PoseError> final_refined_error() const;
  /// rad, the median error of the single detections; absent without any.
  [[nodiscard]] std::optional<double> median_detection_angle() const;
};

struct RunMetrics {
  std::vector<ObjectHistory> objects;
  std::vector<std::string> extra;  ///< confirmed estimates that no object of the truth explains

  /// Every object of the truth is found, within both limits, and nothing else.
  [[nodiscard]] bool Within(double largest_angle, double largest_distance) const;
  /// Every object's final orientation is nearer to the truth than its median single detection.
  [[nodiscard]] bool BetterThanMedianDetection() const;
};

/// Judges a run. Estimates go with the nearest object of the truth of their model, each with one at
/// most; an estimate farther than half its model's diameter from it is none of it.
RunMetrics MeasureRun(const RecordedRun& run, const ReportSetup& setup);

/// Estimates of one message that go with the truth: instance id by place in `truth`.
std::map<size_t, int32_t> MatchToTruth(const object_estimates_v3_t& objects,
                                       const ReportSetup& setup);

}  // namespace vantage
