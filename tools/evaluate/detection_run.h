#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "common/result.h"
#include "perception/model/object_model.h"
#include "tools/evaluate/detection_sequence.h"
#include "tools/evaluate/simulated_sequence.h"

namespace vantage {

struct DetectionRequest {
  SimulationParameters simulation;
  int circles = 1;              ///< sequences of each model on the paper's circle
  int random_sequences = 60;    ///< of each model
  int threads = 1;              ///< more or fewer change nothing but the time
  std::filesystem::path cache;  ///< folder, made when it isn't there
  Result<void> Validate() const;
};

struct ModelDetections {
  std::string model_id;
  std::vector<DetectionSequence> circles;
  std::vector<DetectionSequence> random;
};

struct DetectionRun {
  std::vector<ModelDetections> models;  ///< in the order of the models given
  int64_t views_reused = 0;             ///< of the result, from the cache
  int64_t views_made = 0;
  bool is_complete = false;        ///< false after a stop
  std::vector<std::string> notes;  ///< sentences on damage in the cache that was mended
};

/// Of the views that the cache lacks.
struct DetectionProgress {
  int64_t views_done = 0;
  int64_t views_total = 0;
  std::string model_id;  ///< of the sequence that is done
};

/// What the estimator makes of all requested sequences: from the cache as far as they are there,
/// the others are made and added to it, each when it and all before it in its file are done. After
/// a stop the sequences in work are ended and kept. The same result and the same files for any
/// number of threads.
/// @param progress is called by one thread at a time, before the first and after every sequence;
/// never when the cache has all. May be empty.
/// Errors: a request out of range, two models of one id, the cache (see DetectionCache), a model
/// that can't be trained. What was made until then is kept.
Result<DetectionRun> RunDetections(std::span<const ObjectModel> models,
                                   const DetectionRequest& request,
                                   const std::stop_token& stop,
                                   const std::function<void(const DetectionProgress&)>& progress);

}  // namespace vantage
