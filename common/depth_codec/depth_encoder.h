#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/depth_codec/depth_kernels.h"
#include "common/depth_codec/depth_palette.h"
#include "common/depth_codec/depth_payload.h"
#include "common/depth_codec/depth_rows.h"
#include "common/depth_codec/symbol_frequencies.h"

namespace vantage {

/// Compresses 16-bit depth images without loss. Each image stands for itself: what was lost on the
/// way harms no other. The format is in docs/depth-codec.md.
/// Keeps buffers between images; use one encoder a thread.
class DepthEncoder {
 public:
  explicit DepthEncoder(const DepthKernels& kernels = AvailableDepthKernels().front())
      : kernels_(kernels) {}

  /// @param width, height px, 1..kMaxDepthSide
  /// @param depth width * height values in any unit, 0 where there is no measurement
  std::vector<uint8_t> Encode(int width, int height, std::span<const uint16_t> depth);

  /// The same into a buffer that is used again: nothing is allocated once it is large enough.
  void Encode(int width,
              int height,
              std::span<const uint16_t> depth,
              std::vector<uint8_t>* payload);

 private:
  // `depth`: the first pixel of what is coded; `stride`: from one row to the next.
  void Tokenize(const DepthLayout& layout, const uint16_t* depth, size_t stride);
  void TakeRanks(const DepthLayout& layout, const uint16_t* depth);
  void CountSymbols(const DepthLayout& layout);
  void AppendTables(std::vector<uint8_t>* payload);
  bool AppendWords(const DepthLayout& layout, std::vector<uint8_t>* payload);

  DepthKernels kernels_;
  DepthPalette palette_;
  DepthRows rows_[DepthLayout::kBands];
  SymbolTable table_;
  std::vector<uint16_t> ranks_;                         // of a row of a band, columns x 32
  std::vector<uint8_t> tokens_;                         // rows x columns x 64
  std::vector<uint16_t> words_;                         // filled from its end
  std::vector<uint16_t> escapes_[DepthLayout::kBands];  // room for as many as there may be
  size_t num_escapes_[DepthLayout::kBands] = {};
  uint32_t counts_[kDepthContexts][kDepthSymbols] = {};
};

}  // namespace vantage
