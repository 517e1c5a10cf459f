#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>

namespace vantage {

/// A color as screens want it (sRGB).
struct Rgb {
  uint8_t r = 0;
  uint8_t g = 0;
  uint8_t b = 0;

  bool operator==(const Rgb&) const = default;
};

/// `share` in [0, 1] of `b`, the rest of `a`.
Rgb Mix(Rgb a, Rgb b, double share);
/// "#rrggbb".
std::string HexColor(Rgb color);

/// Depth, from near (t = 0, light) to far (t = 1, dark). Lightness falls evenly, so that it reads
/// in grey too; muted, so that outlines stand out. t is clamped.
Rgb DepthColor(double t);
/// Density, from none (t = 0, pale grey) to the highest (t = 1, deep blue). Blue is the highest as
/// in the paper's figure 3; its red for none is replaced by grey, because the lightness of a
/// rainbow does not rise with the value. t is clamped.
Rgb DensityColor(double t);
/// Color of the i-th object in every figure of a report; told apart with impaired color vision.
Rgb ObjectColor(size_t index);

}  // namespace vantage
