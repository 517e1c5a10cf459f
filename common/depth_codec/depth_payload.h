#pragma once

#include <cstddef>
#include <cstdint>

/// What both ends of the depth codec must know; docs/depth-codec.md says it byte by byte.
namespace vantage {

inline constexpr uint32_t kDepthMagic = 0x01434456U;  ///< "VDC" and the version, 1
inline constexpr size_t kDepthHeaderBytes = 13;
inline constexpr int kMaxDepthSide = 4096;  ///< px

enum class DepthMode : uint8_t {
  kStored = 0,  ///< width * height pixels of 2 bytes
  kCoded = 1,   ///< palette, frequencies, states, words
  kWindow = 2,  ///< left, top, width, height of a window; then as kCoded, of the window alone
};

/// How an image is cut so that 64 pixels can be coded at once: into an upper and a lower band of
/// rows, each into 32 strips of columns. What hangs over the right border counts as unmeasured.
struct DepthLayout {
  static constexpr size_t kStrips = 32;
  static constexpr size_t kBands = 2;
  static constexpr size_t kLanes = kStrips * kBands;

  DepthLayout(int width_px, int height_px)
      : width(static_cast<size_t>(width_px)),
        height(static_cast<size_t>(height_px)),
        columns((width + kStrips - 1) / kStrips),
        rows((height + kBands - 1) / kBands) {}

  /// 1 in the last row of an odd number of rows, which the lower band lacks.
  [[nodiscard]] size_t BandsOf(size_t row) const { return rows + row < height ? 2 : 1; }

  size_t width, height;  ///< px
  size_t columns;        ///< of a strip
  size_t rows;           ///< of the upper band
};

/// Symbols of a pixel: its rank less the predicted one, -2..2 as symbols 1..5; less or more than
/// that; no measurement.
inline constexpr size_t kDepthSymbols = 8;
inline constexpr int kDepthSymbolOfZero = 3;
inline constexpr int kDepthSymbolBelow = 0;
inline constexpr int kDepthSymbolAbove = 6;
inline constexpr int kDepthSymbolInvalid = 7;

/// What lies beyond -2..2 by v - 1 >= 0 is told by the number of v's bits less 1, then the others.
inline constexpr size_t kDepthBuckets = 15;

/// Probabilities are multiples of 1 / kDepthScale.
inline constexpr uint32_t kDepthScaleBits = 14;
inline constexpr uint32_t kDepthScale = 1U << kDepthScaleBits;
/// States of the range coder lie in [kDepthStateLow, 2^32).
inline constexpr uint32_t kDepthStateLow = 1U << 16U;

inline constexpr size_t kDepthContexts = 16;

/// The context of a pixel whose neighbours W, N, NW, NE are all measured. The index is
/// g1 + 5 g2 + 25 g3 of the steps W - NW, N - NW, NE - N, each 2 added to and clamped to 0..4.
/// Found by merging, of the 125, those two again and again whose union cost simulated and real
/// frames least.
inline constexpr uint8_t kDepthGradientContexts[125] = {
    7, 7, 6, 6,  14, 7, 14, 14, 14, 14, 4, 7, 14, 14, 14, 7, 15, 14, 14, 14, 14, 14, 14, 14, 14,
    7, 7, 6, 6,  14, 7, 9,  12, 7,  14, 4, 3, 15, 5,  14, 7, 9,  5,  12, 14, 14, 14, 14, 14, 14,
    7, 4, 6, 6,  14, 4, 3,  10, 12, 11, 6, 2, 1,  9,  14, 7, 9,  5,  12, 14, 14, 14, 14, 12, 14,
    7, 4, 6, 6,  14, 4, 3,  10, 12, 14, 6, 4, 8,  12, 14, 6, 7,  15, 10, 14, 14, 14, 14, 12, 12,
    7, 7, 6, 14, 14, 6, 7,  4,  10, 14, 6, 6, 10, 12, 14, 6, 6,  12, 10, 12, 14, 14, 14, 12, 10};

/// The context where a neighbour is not measured. The index is W + 2 N + 4 NW + 8 NE, each 1 where
/// it is measured; 15 is not used.
inline constexpr uint8_t kDepthValidityContexts[16] = {
    0, 11, 11, 11, 13, 13, 13, 7, 13, 11, 11, 11, 13, 13, 13, 0};

}  // namespace vantage
