#include "tools/support/color.h"

#include <array>
#include <cmath>
#include <span>

#include "common/format.h"

namespace vantage {
namespace {

Rgb Interpolate(std::span<const Rgb> stops, double t) {
  if (!(t > 0.0)) return stops.front();
  if (t >= 1.0) return stops.back();
  const double place = t * static_cast<double>(stops.size() - 1);
  const auto index = static_cast<size_t>(place);
  return Mix(stops[index], stops[index + 1], place - static_cast<double>(index));
}

uint8_t MixChannel(uint8_t a, uint8_t b, double share) {
  return static_cast<uint8_t>(std::lround((1.0 - share) * a + share * b));
}

}  // namespace

Rgb Mix(Rgb a, Rgb b, double share) {
  return {MixChannel(a.r, b.r, share), MixChannel(a.g, b.g, share), MixChannel(a.b, b.b, share)};
}

std::string HexColor(Rgb color) { return Format("#%02x%02x%02x", color.r, color.g, color.b); }

Rgb DepthColor(double t) {
  static constexpr std::array<Rgb, 6> kStops = {Rgb{236, 240, 205},
                                                {158, 211, 185},
                                                {84, 172, 172},
                                                {52, 124, 154},
                                                {46, 78, 122},
                                                {36, 38, 78}};
  return Interpolate(kStops, t);
}

Rgb DensityColor(double t) {
  static constexpr std::array<Rgb, 5> kStops = {
      Rgb{233, 234, 238}, {186, 206, 232}, {112, 160, 218}, {46, 96, 184}, {14, 30, 104}};
  return Interpolate(kStops, t);
}

Rgb ObjectColor(size_t index) {
  static constexpr std::array<Rgb, 8> kColors = {Rgb{217, 84, 26},
                                                 {20, 112, 184},
                                                 {26, 148, 104},
                                                 {176, 72, 148},
                                                 {224, 158, 20},
                                                 {72, 178, 220},
                                                 {120, 86, 40},
                                                 {90, 90, 100}};
  return kColors[index % kColors.size()];
}

}  // namespace vantage
