#pragma once

#include <optional>
#include <span>
#include <string>

#include "common/result.h"
#include "planner/planned_object.h"

namespace vantage {

struct StopParameters {
  double least_gain = 0.05;  ///< nat; views that are expected to tell less are not worth the way
  double sure = 0.95;        ///< probability of the best hypothesis that is enough

  Result<void> Validate() const;
};

/// Why nothing is left to be found out, in words; empty while there is. All confirmed objects (at
/// least one) must have converged; of those with a confusion model and a belief, the best
/// hypothesis must also be as sure as asked for, and no view may promise more than the least gain.
/// @param information nat, the most that any view left is expected to tell about objects with a
/// confusion model; none: the criterion in use does not say.
std::string StopReason(const StopParameters& parameters,
                       std::span<const PlannedObject> objects,
                       std::optional<double> information,
                       size_t num_views);

}  // namespace vantage
