#pragma once

#include <array>
#include <cstdint>

// What the emulated cameras see: the truth that tests hold against what a driver makes of it. It
// moves: frame n shows phase n % kNumPhases.
namespace vantage::v4l2_shim {

inline constexpr int kNumPhases = 8;

struct YCbCr {
  uint8_t y = 0;
  uint8_t cb = 0;
  uint8_t cr = 0;
};

/// Of formats that keep every pixel: no two neighbors are alike. Chroma is of pairs of columns.
inline YCbCr SharpColor(int x, int y, int phase) {
  const auto chroma = [](int value) { return static_cast<uint8_t>(64 + value % 128); };
  return {static_cast<uint8_t>(16 + (3 * x + 5 * y + 31 * phase) % 220),
          chroma(7 * (x / 2) + 3 * y + 11 * phase),
          chroma(5 * (x / 2) + 9 * y + 13 * phase + 40)};
}

/// Red, green, blue, of formats that blur: they change slowly and evenly.
inline std::array<uint8_t, 3> SmoothColor(int x, int y, int phase, int width, int height) {
  return {static_cast<uint8_t>(40 + 100 * x / width + 4 * phase),
          static_cast<uint8_t>(190 - 110 * y / height - 4 * phase),
          static_cast<uint8_t>(30 + 60 * x / width + 70 * y / height + 4 * phase)};
}

/// Of Y16 and Z16; 0: no measurement.
inline uint16_t DepthValue(int x, int y, int phase) {
  if ((x + y + phase) % 11 == 0) return 0;
  return static_cast<uint16_t>(500 + (7 * x + 13 * y + 101 * phase) % 4000);
}

inline constexpr uint16_t kNoDisparity = 1023;

/// Of Y10BPACK, in the Kinect's unit.
inline uint16_t DisparityValue(int x, int y, int phase) {
  if ((x + y + phase) % 11 == 0) return kNoDisparity;
  return static_cast<uint16_t>(400 + (3 * x + 5 * y + 17 * phase) % 600);
}

}  // namespace vantage::v4l2_shim
