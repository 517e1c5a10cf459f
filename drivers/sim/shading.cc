#include "drivers/sim/shading.h"

#include <array>

namespace vantage {

void ShadeColor(const RenderedView& view, std::vector<uint8_t>* rgb) {
  using Rgb = std::array<float, 3>;
  constexpr std::array<Rgb, 8> kPalette = {Rgb{226, 132, 80},
                                           Rgb{90, 150, 210},
                                           Rgb{110, 180, 110},
                                           Rgb{215, 185, 90},
                                           Rgb{170, 120, 190},
                                           Rgb{205, 205, 200},
                                           Rgb{200, 95, 110},
                                           Rgb{95, 180, 180}};
  constexpr float kAmbient = 0.25F;
  constexpr uint8_t kBackground = 40;
  rgb->resize(3 * view.surface.size());
  for (size_t i = 0; i < view.surface.size(); ++i) {
    uint8_t* pixel = rgb->data() + 3 * i;
    if (view.surface[i] == RenderedView::kNoSurface) {
      pixel[0] = pixel[1] = pixel[2] = kBackground;
      continue;
    }
    const Rgb& color = kPalette[view.surface[i] % kPalette.size()];
    const float light = kAmbient + (1.0F - kAmbient) * view.cos_incidence[i];
    for (size_t c = 0; c < 3; ++c) pixel[c] = static_cast<uint8_t>(color[c] * light);
  }
}

}  // namespace vantage
