#pragma once

#include <optional>
#include <vector>

#include "perception/verification/verification.h"
#include "tools/support/stage_image.h"
#include "tools/support/stage_panel.h"
#include "tools/support/stage_trace.h"

namespace vantage {

/// Six panels: depth, segments, and of one cluster its scene points, proposed poses and
/// verification; then what was detected.
/// @param cluster index; nothing when there are none.
std::vector<StagePanel> DrawStages(const StageTrace& trace,
                                   const StageImage& image,
                                   const VerificationParameters& parameters,
                                   double min_height,
                                   std::optional<size_t> cluster);

}  // namespace vantage
