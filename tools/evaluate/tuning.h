#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "tools/evaluate/fusion_methods.h"
#include "tools/evaluate/method_run.h"

namespace vantage {

struct TuningParameters {
  MethodRunOptions run;
  double wrong_mode_deg = 10.0;  ///< as the evaluation's
  /// A candidate with a wrong-mode rate higher than the least by more than this is not chosen,
  /// whatever its median.
  double rate_tolerance = 0.01;
};

/// How a method did with some values of its parameters; errors of the final orientation modulo
/// symmetry.
struct TuningTrial {
  std::string method_id;
  std::string parameters;  ///< all, in words
  std::vector<double> values;
  double median_deg = 0.0;
  double mean_deg = 0.0;
  double wrong_mode_rate = 0.0;  ///< sequences without estimate count as wrong, by 180 deg
  double seconds_per_view = 0.0;
  bool is_best = false;  ///< of its method
  bool is_used = false;  ///< what the evaluation has
};

/// How far the search is: sequences fused, of about as many as there will be.
using TuningProgress = std::function<void(int64_t done, int64_t total)>;

/// Tries values of a method's parameters on the same sequences: each parameter in turn, the others
/// at the best so far, from the values in use on until a whole turn finds nothing better. So the
/// values in use stay the best where they are. Of candidates whose wrong-mode rate is near the
/// least the one with the least median is best; of equal ones the first that was tried.
/// @return in the order of trying; empty after a stop.
std::vector<TuningTrial> TuneMethod(const TunableMethod& method,
                                    std::span<const EvaluatedSequence> sequences,
                                    const TuningParameters& parameters,
                                    const std::stop_token& stop,
                                    const TuningProgress& progress);

/// The place of the best trial as above; `trials` is not empty.
size_t BestTrial(std::span<const TuningTrial> trials, double rate_tolerance);

/// method,parameters,median_deg,mean_deg,wrong_mode_rate,seconds_per_view,is_best,is_used
std::string TuningCsv(std::span<const TuningTrial> trials);
/// The best of every method and what is used, as lines for a console.
std::string TuningText(std::span<const TuningTrial> trials);

}  // namespace vantage
