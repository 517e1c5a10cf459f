#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/depth_codec/depth_payload.h"

namespace vantage {

/// Turns counts into frequencies that sum to kDepthScale, each at least 1, and such that
/// AppendFrequencies can tell them.
void NormalizeFrequencies(std::span<const uint32_t> counts, std::span<uint16_t> frequencies);

/// One byte for the most frequent symbol, whose frequency is what the others leave, and one for
/// each of these: c for ((4 + c % 4) * 2^(c / 4)) / 4, rounded down.
void AppendFrequencies(std::span<const uint16_t> frequencies, std::vector<uint8_t>* bytes);

/// Reads frequencies.size() bytes. @return false where these are no frequencies.
bool ReadFrequencies(std::span<const uint8_t> bytes, std::span<uint16_t> frequencies);

/// Frequencies and their sums of all contexts, as the range coder looks them up.
struct SymbolTable {
  static constexpr size_t kEntries = kDepthContexts * kDepthSymbols;

  /// Index: context + 16 * symbol.
  alignas(64) uint16_t frequency[kEntries];
  alignas(64) uint16_t start[kEntries];
  /// Of what lies beyond -2..2.
  uint16_t bucket_frequency[kDepthBuckets];
  uint16_t bucket_start[kDepthBuckets + 1];
  /// The first bucket of so many slots that follow each other.
  static constexpr uint32_t kSlotsTogether = 64;
  uint8_t bucket_of_slot[kDepthScale / kSlotsTogether];

  void SetContext(size_t context, std::span<const uint16_t> frequencies);
  void SetBuckets(std::span<const uint16_t> frequencies);
};

}  // namespace vantage
