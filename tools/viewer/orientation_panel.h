#pragma once

#include "tools/viewer/page.h"
#include "tools/viewer/viewer_options.h"
#include "tools/viewer/viewer_state.h"

namespace vantage {

/// The orientation of one object: its histogram on the sphere (paper 4.1), what that view hides, by
/// color (one half of the panel each), and the circles over the heaviest spots.
void DrawOrientationPanel(const ViewerState& state,
                          const ViewerOptions& options,
                          const PixelBox& box,
                          Page* page);

}  // namespace vantage
