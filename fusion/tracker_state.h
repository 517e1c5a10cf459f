#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "common/result.h"
#include "common/so3.h"
#include "fusion/viewpoints.h"

namespace vantage {

/// Names a set of detections: the same set sent again has the same key, a new one of a restarted
/// estimator, which counts from 0 again, has not.
struct SetKey {
  std::string channel;
  int64_t seq = 0;
  int64_t utime = 0;  ///< us

  bool operator==(const SetKey&) const = default;
};

/// The detection that stands for one viewpoint in an object's estimate.
struct Observation {
  int viewpoint = 0;  ///< index into TrackerState::viewpoints
  SetKey source;
  int index = 0;  ///< place in the set's detections
  Pose T_world_object = Pose::Identity();
  double mse = 0.0;                 ///< m^2
  double verification_score = 0.0;  ///< [0, 1]
};

/// One object in the scene.
struct Instance {
  int id = 0;
  std::string model_id;
  std::vector<Observation> observations;  ///< at least one; by viewpoint, one each
};

/// All that ObjectTracker remembers; everything else it knows follows from this.
struct TrackerState {
  std::vector<Viewpoint> viewpoints;
  std::vector<Instance> instances;  ///< by id
  int next_id = 0;
  std::deque<SetKey> recent_sets;  ///< the last ones used, to know them when they come again
};

/// As text, one record a line, numbers exact.
std::string FormatTrackerState(const TrackerState& state);
/// Inverse of FormatTrackerState. Errors: anything that it would not have written, naming the line.
Result<TrackerState> ParseTrackerState(const std::string& text);

}  // namespace vantage
