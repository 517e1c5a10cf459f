#pragma once

#include <cstdint>
#include <vector>

#include "drivers/sim/scene_renderer.h"

namespace vantage {

/// Colour image of a view, RGB888 row by row: a colour for each surface, shaded by Lambert's law
/// with the light at the camera.
void ShadeColor(const RenderedView& view, std::vector<uint8_t>* rgb);

}  // namespace vantage
