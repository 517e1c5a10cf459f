#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/depth_codec/depth_kernels.h"
#include "common/depth_codec/depth_palette.h"
#include "common/depth_codec/depth_payload.h"
#include "common/depth_codec/depth_rows.h"
#include "common/depth_codec/symbol_frequencies.h"
#include "common/result.h"

namespace vantage {

/// Reads what DepthEncoder writes. Keeps buffers between images; use one decoder a thread.
class DepthDecoder {
 public:
  explicit DepthDecoder(const DepthKernels& kernels = AvailableDepthKernels().front())
      : kernels_(kernels) {}

  /// @param payload from outside; may hold anything
  /// @param width, height px, what the image must be; 1..kMaxDepthSide
  /// @param depth width * height values; after an error its content is unspecified
  /// Errors: no such payload, or of another version or size, or damaged. Memory is taken in
  /// proportion to width * height and to the bytes there are, whatever these claim.
  Result<void> Decode(std::span<const uint8_t> payload,
                      int width,
                      int height,
                      std::vector<uint16_t>* depth);

 private:
  // What is wrong, or nothing.
  std::string DecodeStored(std::span<const uint8_t> bytes, std::vector<uint16_t>* depth);
  std::string DecodeWindow(const DepthLayout& image,
                           std::span<const uint8_t> bytes,
                           std::vector<uint16_t>* depth);
  // Into `depth`, with `stride` from one row to the next.
  std::string DecodeCoded(const DepthLayout& layout,
                          std::span<const uint8_t> bytes,
                          uint16_t* depth,
                          size_t stride);
  bool ReadTables(std::span<const uint8_t>* bytes);
  bool DecodeRows(const DepthLayout& layout, size_t num_words, uint16_t* depth, size_t stride);
  void PutRow(const DepthLayout& layout, const uint16_t* ranks, uint16_t* depth) const;

  DepthKernels kernels_;
  DepthPalette palette_;
  DepthRows rows_[DepthLayout::kBands];
  SymbolTable table_;
  uint32_t states_[DepthLayout::kLanes] = {};
  std::vector<uint16_t> ranks_[DepthLayout::kBands];  // of a row of a band, columns x 32
  std::vector<uint16_t> words_;
};

}  // namespace vantage
