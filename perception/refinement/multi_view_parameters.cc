#include "perception/refinement/multi_view_parameters.h"

#include <cmath>

#include "common/format.h"

namespace vantage {

Result<void> MultiViewParameters::Validate() const {
  struct Bound {
    const char* name;
    double value, lowest, highest;
  };
  const Bound bounds[] = {
      {"rounds", static_cast<double>(rounds), 1.0, 100.0},
      {"points", static_cast<double>(points), 100.0, 1e6},
      {"edge_px", static_cast<double>(edge_px), 0.0, 20.0},
      {"correlation_px", correlation_px, 0.0, 2.0},
      {"camera_rotation", camera_rotation, 0.0, 1.0},
      {"camera_translation", camera_translation, 0.0, 1.0},
      {"view_rotation", view_rotation, 0.0, 1.0},
      {"view_translation", view_translation, 0.0, 1.0},
      {"hand_eye_rotation", hand_eye_rotation, 0.0, 1.0},
      {"hand_eye_translation", hand_eye_translation, 0.0, 1.0},
      {"min_views", static_cast<double>(min_views), 1.0, 1000.0},
  };
  for (const Bound& bound : bounds) {
    if (bound.value >= bound.lowest && bound.value <= bound.highest) continue;
    return Error{ErrorCode::kInvalidArgument,
                 Format("refinement over several views: %s = %g, expected %g to %g",
                        bound.name,
                        bound.value,
                        bound.lowest,
                        bound.highest)};
  }
  if (adjust_hand_eye && !(hand_eye_rotation > 0.0 && hand_eye_translation > 0.0)) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("refinement over several views: hand_eye_rotation = %g rad and "
                        "hand_eye_translation = %g m, expected above 0 where it is adjusted",
                        hand_eye_rotation,
                        hand_eye_translation)};
  }
  return single.Validate();
}

}  // namespace vantage
