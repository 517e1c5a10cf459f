#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <stop_token>
#include <vector>

#include "common/symmetry_group.h"
#include "tools/evaluate/detection_sequence.h"
#include "tools/evaluate/fusion_methods.h"

namespace vantage {

class MethodCache;

/// A sequence and what its object's errors are taken modulo.
struct EvaluatedSequence {
  const DetectionSequence* sequence = nullptr;
  const SymmetryGroup* symmetry = nullptr;
};

/// What a method made of one sequence. Errors by view: after so many views, deg; NaN while there is
/// no estimate.
struct SequenceOutcome {
  std::vector<double> error_deg;
  std::vector<double> symmetric_deg;
  double seconds_per_view = 0.0;  ///< processor time of an update and an estimate
};

/// Lets a method fuse the best hypothesis of every view of a sequence, in their order.
SequenceOutcome RunMethod(const FusionMethod& method,
                          const EvaluatedSequence& evaluated,
                          uint64_t seed);

struct MethodRunOptions {
  uint64_t seed = 1;             ///< the i-th sequence has seed + i
  int threads = 1;               ///< more or fewer change nothing but the time
  MethodCache* cache = nullptr;  ///< of slow methods' outcomes; null: none
};

/// Lets every method fuse every sequence: [method][sequence]. Empty after a stop; what slow methods
/// did until then is in the cache.
/// @param progress is called by one thread at a time with the number of sequences done; may be
/// empty.
std::vector<std::vector<SequenceOutcome>> RunMethods(std::span<const FusionMethod> methods,
                                                     std::span<const EvaluatedSequence> sequences,
                                                     const MethodRunOptions& options,
                                                     const std::stop_token& stop,
                                                     const std::function<void(int64_t)>& progress);

}  // namespace vantage
