#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <stop_token>
#include <vector>

#include "common/result.h"
#include "perception/model/object_model.h"
#include "tools/evaluate/detection_run.h"
#include "tools/evaluate/evaluation_results.h"
#include "tools/evaluate/fusion_methods.h"
#include "tools/evaluate/method_cache.h"

namespace vantage {

struct EvaluationParameters {
  uint64_t seed = 1;  ///< of methods and of the bootstrap
  int threads = 1;    ///< more or fewer change nothing but the time
  /// deg, modulo symmetry. Twice the standard deviation of what the compared methods take for one
  /// mode: an error that no averaging of right detections leaves.
  double wrong_mode_deg = 10.0;
  int early_views = 3;     ///< after which the wrong-mode rate is taken too
  int particle_runs = 20;  ///< of the particle filter on each circle shown in Fig. 10
  int bootstrap_resamples = 2000;
  std::vector<std::string> figure10_models;  ///< models with all those runs; others have one
  MethodCache* cache = nullptr;              ///< of slow methods' outcomes; null: none

  Result<void> Validate() const;
};

/// How far the fusion is: sequences done, of all.
using FusionProgress = std::function<void(int64_t done, int64_t total)>;

/// Lets all methods fuse the same detections and judges them. `results` keeps what else it holds.
/// @param models those of `detections`, in the same order.
/// @return false after a stop; `results` is then of no use.
bool EvaluateMethods(std::span<const ObjectModel> models,
                     const std::vector<ModelDetections>& detections,
                     std::span<const FusionMethod> methods,
                     const EvaluationParameters& parameters,
                     const std::stop_token& stop,
                     const FusionProgress& progress,
                     EvaluationResults* results);

/// Bars of the accuracy that `results` misses, a sentence each: the best variant of ours has a
/// median and a wrong-mode rate no worse than every compared method, voting included, and the
/// interval of each difference of medians excludes 0.
std::vector<std::string> MissedBars(const EvaluationResults& results);

}  // namespace vantage
