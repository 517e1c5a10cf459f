#include "planner/stop_rule.h"

#include <algorithm>
#include <cmath>

#include "common/format.h"

namespace vantage {

Result<void> StopParameters::Validate() const {
  if (least_gain >= 0.0 && std::isfinite(least_gain) && sure > 0.0 && sure < 1.0) return {};
  return Error{
      ErrorCode::kInvalidArgument,
      Format("least_gain = %g nat and sure = %g, expected 0 or more and above 0 to below 1",
             least_gain,
             sure)};
}

std::string StopReason(const StopParameters& parameters,
                       std::span<const PlannedObject> objects,
                       std::optional<double> information,
                       size_t num_views) {
  int num_confirmed = 0;
  int num_believed = 0;
  double least_sure = 1.0;
  for (const PlannedObject& object : objects) {
    if (!object.confirmed) continue;
    ++num_confirmed;
    if (!object.converged) return {};
    if (object.confusion == nullptr || object.belief.empty()) continue;
    ++num_believed;
    least_sure = std::min(least_sure, object.belief.front().probability);
  }
  if (num_confirmed == 0) return {};
  std::string reason =
      Format("all %d confirmed objects converged after %zu views", num_confirmed, num_views);
  if (num_believed == 0) return reason;
  if (!(least_sure >= parameters.sure)) return {};
  reason +=
      Format(", the least sure of %d orientations to %.1f %%", num_believed, 100.0 * least_sure);
  if (!information.has_value()) return reason;
  if (*information >= parameters.least_gain) return {};
  return reason + Format(", and no view left is expected to tell more than %.2g nat", *information);
}

}  // namespace vantage
