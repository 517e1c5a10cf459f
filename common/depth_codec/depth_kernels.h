#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "common/depth_codec/depth_payload.h"
#include "common/depth_codec/symbol_frequencies.h"

namespace vantage {

/// A row of a band, columns x 32 strips, as the rows below it see it. The first and the last of
/// columns + 2 vectors are the neighbouring strips' last and first columns.
struct DepthRowView {
  uint16_t* ranks;  ///< where there is no measurement, what was predicted
  uint32_t* valid;  ///< a bit for each strip
};

/// A row of a band on its way to symbols.
struct TokenizeTask {
  size_t columns;
  const uint16_t* ranks;  ///< columns x 32, 0: no measurement
  DepthRowView above;
  DepthRowView row;    ///< written, but for the first and the last vector
  uint8_t* tokens;     ///< written: context + 16 * symbol, 32 for every column, 64 apart
  uint16_t* escapes;   ///< what lies beyond -2..2 is appended; room for columns x 32
  size_t num_escapes;  ///< in and out
};

/// A row of both bands, or of the upper one alone, on its way to words, last pixel first.
struct EncodeTask {
  size_t columns;
  size_t bands;
  const SymbolTable* table;
  const uint8_t* tokens;                         ///< columns x 64
  const uint16_t* escapes[DepthLayout::kBands];  ///< ends of what is to be coded; in and out
  uint32_t* states;                              ///< 64, in and out
  uint16_t* words;                               ///< they are put before this; in and out
};

/// A row of both bands, or of the upper one alone, on its way back.
struct DecodeTask {
  size_t columns;
  size_t bands;
  size_t num_ranks;  ///< of the palette
  const SymbolTable* table;
  DepthRowView above[DepthLayout::kBands];
  DepthRowView row[DepthLayout::kBands];  ///< written as by TokenizeTask
  uint16_t* ranks[DepthLayout::kBands];   ///< written: columns x 32, 0: no measurement
  uint32_t* states;                       ///< 64, in and out
  const uint16_t* words;                  ///< in and out; kWordsPerPixel for each are readable
  bool sound;                             ///< set to false where a rank is beyond the palette
};

/// How far a residual lies beyond -2..2, from 1 on.
[[gnu::always_inline]] inline uint32_t EscapeDistance(uint16_t residual) {
  const int value = static_cast<int16_t>(residual);
  return static_cast<uint32_t>(value < 0 ? -value : value) - 2U;
}
/// The number of its bits less 1.
[[gnu::always_inline]] inline uint32_t EscapeBucket(uint32_t distance) {
  return 31U - static_cast<uint32_t>(__builtin_clz(distance));
}

/// A pixel takes or gives at most so many words.
inline constexpr size_t kWordsPerPixel = 3;

/// The loops over pixels. Every set gives the same bytes.
struct DepthKernels {
  const char* name;  ///< the instruction set
  /// Sets present[value] to 1 for all values of an image.
  void (*mark_values)(const uint16_t* depth, size_t size, size_t width, uint8_t* present);
  void (*tokenize)(TokenizeTask*);
  void (*encode)(EncodeTask*);
  void (*decode)(DecodeTask*);
};

/// What this processor can run, the fastest first; "portable" always comes last.
std::span<const DepthKernels> AvailableDepthKernels();

extern const DepthKernels kPortableDepthKernels;
extern const DepthKernels kAvx2DepthKernels;
extern const DepthKernels kAvx512DepthKernels;

}  // namespace vantage
