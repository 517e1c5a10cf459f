#include "perception/shot/shot_parameters.h"

#include "common/format.h"
#include "perception/shot/shot_features.h"

namespace vantage {
namespace {

Result<void> CheckRange(const char* name, double value, double low, double high) {
  if (value >= low && value <= high) return {};
  return Error{ErrorCode::kInvalidArgument,
               Format("shot: %s = %g (expected %g to %g)", name, value, low, high)};
}

}  // namespace

Result<void> ShotParameters::Validate() const {
  for (const Result<void>& valid :
       {CheckRange("spacing", spacing, 0.005, 0.2),
        CheckRange("keypoint_spacing", keypoint_spacing, spacing, 0.5),
        CheckRange("descriptor_radius", descriptor_radius, spacing, 1.0),
        CheckRange("training_views", training_views, 1, 2000),
        CheckRange("descriptor_size", descriptor_size, 1, double{kShotSize}),
        CheckRange("k", k, 1, 100),
        CheckRange("t_r", t_r, 0.0, 1.0),
        CheckRange("t_d", t_d, 0.0, 1.0),
        CheckRange("t_alpha_deg", t_alpha_deg, 0.0, 180.0),
        CheckRange("inlier_distance", inlier_distance, 1e-6, 1.0),
        CheckRange("probability", probability, 0.0, 0.999999),
        CheckRange("max_iterations", max_iterations, 1, 1e8),
        CheckRange("max_hypotheses", max_hypotheses, 1, 1000)}) {
    if (!valid) return valid;
  }
  return {};
}

}  // namespace vantage
