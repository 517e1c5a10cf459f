#pragma once

#include <vtkRenderer.h>

#include "tools/viewer/viewer_scene.h"

namespace vantage {

/// Replaces what two renderers show: `solid` what hides each other, `on_top` what is seen through
/// it, and the labels.
void FillRenderers(const ViewerScene& scene, vtkRenderer& solid, vtkRenderer& on_top);

}  // namespace vantage
