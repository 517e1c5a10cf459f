#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>

#include "common/result.h"
#include "fusion/confusion/confusion_model.h"
#include "fusion/confusion/contingency_table.h"
#include "fusion/confusion/stopping_rule.h"
#include "perception/model/object_model.h"
#include "tools/contingency/trial_simulator.h"
#include "tools/evaluate/confusion_results.h"

namespace vantage {

/// How the contingency tables of an evaluation are measured.
struct ConfusionTableParameters {
  TrialParameters trials;
  /// A direction in which all trials agree ends after 26: with so many objects the trials of its
  /// neighbors, which ConfusionModel takes in, must do.
  StoppingParameters stopping{.largest_confusion = 0.2, .widest = 0.4};
  uint64_t seed = 1;
  int k = 8;                     ///< as many viewing directions as suit the grid of this k
  int threads = 1;               ///< more or fewer change nothing but the time
  std::filesystem::path models;  ///< folder that has MODEL/confusion-ppf.bin where it was measured
  std::filesystem::path cache;   ///< folder
};

struct FoundTable {
  ContingencyTable table;
  std::string source;  ///< "model", "cache", "measured"
};

/// The table of one model: that in the model's folder when it is of the same mesh, estimator and
/// sensor and has as many directions; otherwise from the cache, measured as far as it is not there.
/// Nothing after a stop; what was measured until then is kept.
/// @param progress is called by one thread at a time with directions done and all.
/// Errors: parameters, the cache, a model that can't be trained.
Result<std::optional<FoundTable>> FindOrMeasureTable(
    const ObjectModel& model,
    const ConfusionTableParameters& parameters,
    const std::stop_token& stop,
    const std::function<void(int64_t, int64_t)>& progress);

/// What a report says of a table.
TableFacts FactsOf(const ObjectModel& model,
                   const FoundTable& found,
                   const ConfusionModel& confusion);

}  // namespace vantage
