#pragma once

#include "tools/viewer/page.h"
#include "tools/viewer/viewer_options.h"
#include "tools/viewer/viewer_state.h"

namespace vantage {

/// Objects by viewpoint, the last that fit: the weights of each one's peaks after it, and how far
/// the detection of that viewpoint alone is off, and from which peak.
void DrawStepsPanel(const ViewerState& state,
                    const ViewerOptions& options,
                    const PixelBox& box,
                    Page* page);

}  // namespace vantage
