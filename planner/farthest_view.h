#pragma once

#include "planner/view_criterion.h"

namespace vantage {

/// Gain: angle (rad), seen from the target, between the candidate and the visited view nearest to
/// it; pi while none was visited. Needs no model of the objects: views far from each other have
/// the least in common.
ViewCriterion FarthestView();

}  // namespace vantage
