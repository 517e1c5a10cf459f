#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "common/result.h"
#include "tools/evaluate/confusion_results.h"

namespace vantage {

/// What of measured confusion is evaluated.
struct ConfusionRequest {
  std::vector<std::string> use;             ///< objects; empty: all that are evaluated
  std::filesystem::path models = "models";  ///< of bundled objects; others are generated
  std::filesystem::path cache;              ///< folder of tables, detections and views
  int sequences = 40;  ///< of each object; Table 3 has a quarter as many circles
  int views = 15;      ///< of a sequence
  uint64_t seed = 1;
  int threads = 1;  ///< more or fewer change nothing but the time
};

/// A part of the work begins: what is counted ("directions of filter").
using ConfusionProgress = std::function<std::function<void(int64_t, int64_t)>(const std::string&)>;

/// Measures or finds the contingency tables, fuses circles of views with and without them (Table 3,
/// Fig. 16, 17), draws tables (Fig. 5, 6) and runs every way to choose the next view (Fig. 18 and
/// views until the right mode holds). All follows from the seed; what takes long is cached, so that
/// an interrupted run goes on where it ended.
/// @return false after a stop.
/// Errors: an object of no such name, parameters, the cache.
Result<bool> EvaluateConfusion(const ConfusionRequest& request,
                               const std::stop_token& stop,
                               const ConfusionProgress& progress,
                               ConfusionResults* results);

}  // namespace vantage
