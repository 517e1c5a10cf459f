#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "common/result.h"
#include "common/statistics.h"
#include "perception/model/object_model.h"

namespace vantage {

/// One simulated sequence, fused, and its depth refined from there.
struct RefinedSequence {
  std::string model_id;
  int index = 0;
  int views = 0;  ///< that the object was found in
  double fused_deg = 0.0;
  double refined_deg = 0.0;  ///< of what is returned: the fused one where it is refused
  double fused_mm = 0.0;     ///< of the model's center
  double refined_mm = 0.0;
  bool is_refined = false;
  std::string note;
  /// Of the error in the covariance's metric; of five numbers where a turn is free, else of six.
  double squared_deviation = 0.0;
  int freedom = 6;
  double seconds = 0.0;  ///< processor time of the refinement
};

/// The views of an object on a turntable, whose camera poses markers tell.
struct TurntableRefinement {
  int views = 0;
  double truth_deg = 0.0;        ///< refined to the markers' pose of the model
  double fused_truth_deg = 0.0;  ///< fused likewise
  double consensus_deg = 0.0;    ///< refined to the mean of every view's own ICP
  double fused_consensus_deg = 0.0;
  double nearest_view_deg = 0.0;  ///< the ICP of the view that is nearest to it
  double truth_mm = 0.0;
  double consensus_mm = 0.0;
  double nearest_view_mm = 0.0;
  bool is_refined = false;
  std::string note;
};

struct RefinementStudyResults {
  std::string command;
  std::string version;
  uint64_t seed = 0;
  std::vector<RefinedSequence> sequences;  ///< by model
  std::optional<TurntableRefinement> turntable;
};

struct RefinementRequest {
  std::filesystem::path cache;  ///< of detections
  int sequences = 20;           ///< of each model
  int views = 12;
  uint64_t seed = 1;
  int threads = 1;  ///< that make detections; more or fewer change nothing but the time
};

/// What a part of the sequences says, such as those of one model.
struct RefinementSummary {
  std::string name;
  int count = 0;
  int refused = 0;
  Interval fused_deg, refined_deg;  ///< medians, bootstrap intervals of 95 %
  double fused_mm = 0.0, refined_mm = 0.0;
  double largest_ratio = 0.0;                       ///< of a sequence's error after to before
  int worse = 0;                                    ///< sequences with a ratio above 1.1
  double fused_90_deg = 0.0, refined_90_deg = 0.0;  ///< 90 % are below
  double coverage = 0.0;       ///< of the covariance's 95 % ellipsoid, of those refined
  double seconds_of_10 = 0.0;  ///< median, of 10 views
};

/// All sequences first, then by model.
std::vector<RefinementSummary> Summarize(const RefinementStudyResults& results);

/// Bars that are missed, a sentence each: half of the fused median, no sequence above 1.1 times the
/// fused error, 50 ms for 10 views, 1.3 deg and nearer than any view on the turntable.
std::vector<std::string> MissedBars(const RefinementStudyResults& results);

/// Simulates sequences, fuses their detections by the density mode that knows the symmetry, and
/// refines from there on the same depth.
/// @return false after a stop. Errors: as RunDetections.
Result<bool> StudyRefinement(const std::vector<ObjectModel>& models,
                             const RefinementRequest& request,
                             const std::stop_token& stop,
                             const std::function<void(int64_t done, int64_t total)>& progress,
                             RefinementStudyResults* results);

/// The same of turntable_dataset.h's folder with world_T_camera_NN.txt and world_T_model.txt.
Result<TurntableRefinement> RefineTurntable(const std::filesystem::path& folder,
                                            const std::filesystem::path& meshes);

}  // namespace vantage
