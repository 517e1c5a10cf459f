#pragma once

#include <numbers>

#include "common/so3.h"
#include "planner/view_criterion.h"

namespace vantage {

/// A circle above the objects in 30 steps, as the paper's (Fig. 13).
struct CircleViewParameters {
  double elevation = 45.0 * kDegree;          ///< rad, seen from the target
  double step = 2.0 * std::numbers::pi / 30;  ///< rad of azimuth from view to view

  /// Errors: an elevation beyond -90 to 90 degrees; a step that is 0 or beyond 180 degrees.
  Result<void> Validate() const;
};

/// Gain: pi less the angle (rad), seen from the target, to the next place on the circle. The first
/// visited view gives the azimuth to count from; before it, that is 0.
ViewCriterion CircleView(const CircleViewParameters& parameters = {});

}  // namespace vantage
