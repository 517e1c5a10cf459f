#include "common/depth_codec/symbol_frequencies.h"

#include <algorithm>
#include <bit>
#include <cstddef>

#include "common/check.h"

namespace vantage {
namespace {

constexpr uint32_t kLargestCode = 55;  // Of the frequencies below kDepthScale.

constexpr uint32_t FrequencyOfCode(uint32_t code) {
  return ((4U + (code & 3U)) << (code >> 2U)) >> 2U;
}

// The code of the nearest frequency; for one that has a code, this code.
uint32_t NearestCode(uint32_t frequency) {
  if (frequency < 4) return frequency <= 1 ? 0 : 2 * frequency;
  const auto shift = static_cast<uint32_t>(std::bit_width(frequency)) - 3U;
  const uint32_t code = ((shift + 2U) << 2U) | ((frequency >> shift) & 3U);
  const uint32_t below = FrequencyOfCode(code);
  const uint32_t above = FrequencyOfCode(code + 1);
  const bool up = frequency - below > above - frequency && code < kLargestCode;
  return up ? code + 1 : code;
}

}  // namespace

void NormalizeFrequencies(std::span<const uint32_t> counts, std::span<uint16_t> frequencies) {
  uint64_t total = 0;
  for (const uint32_t count : counts) total += count;
  const auto most = static_cast<size_t>(std::ranges::max_element(counts) - counts.begin());
  for (uint32_t less = 0;; ++less) {
    uint32_t sum = 0;
    for (size_t i = 0; i < counts.size(); ++i) {
      if (i == most) continue;
      const auto exact = static_cast<uint32_t>((uint64_t{counts[i]} * kDepthScale + total / 2) /
                                               std::max<uint64_t>(total, 1));
      const uint32_t code = NearestCode(exact);
      frequencies[i] = static_cast<uint16_t>(FrequencyOfCode(code - std::min(code, less)));
      sum += frequencies[i];
    }
    if (sum >= kDepthScale) continue;  // Rounding went up too often.
    frequencies[most] = static_cast<uint16_t>(kDepthScale - sum);
    return;
  }
}

void AppendFrequencies(std::span<const uint16_t> frequencies, std::vector<uint8_t>* bytes) {
  // Any symbol but the ones that have no code may be the one that is left out.
  size_t left_out = 0;
  for (size_t i = 0; i < frequencies.size(); ++i) {
    if (FrequencyOfCode(NearestCode(frequencies[i])) != frequencies[i]) left_out = i;
  }
  bytes->push_back(static_cast<uint8_t>(left_out));
  for (size_t i = 0; i < frequencies.size(); ++i) {
    if (i != left_out) bytes->push_back(static_cast<uint8_t>(NearestCode(frequencies[i])));
  }
}

bool ReadFrequencies(std::span<const uint8_t> bytes, std::span<uint16_t> frequencies) {
  VANTAGE_CHECK(bytes.size() == frequencies.size(), "one byte a symbol");
  const size_t left_out = bytes[0];
  if (left_out >= frequencies.size()) return false;
  uint32_t sum = 0;
  size_t next = 1;
  for (size_t i = 0; i < frequencies.size(); ++i) {
    if (i == left_out) continue;
    const uint32_t code = bytes[next++];
    if (code > kLargestCode) return false;
    frequencies[i] = static_cast<uint16_t>(FrequencyOfCode(code));
    sum += frequencies[i];
  }
  if (sum >= kDepthScale) return false;
  frequencies[left_out] = static_cast<uint16_t>(kDepthScale - sum);
  return true;
}

void SymbolTable::SetContext(size_t context, std::span<const uint16_t> frequencies) {
  uint32_t sum = 0;
  for (size_t symbol = 0; symbol < kDepthSymbols; ++symbol) {
    frequency[context + kDepthContexts * symbol] = frequencies[symbol];
    start[context + kDepthContexts * symbol] = static_cast<uint16_t>(sum);
    sum += frequencies[symbol];
  }
}

void SymbolTable::SetBuckets(std::span<const uint16_t> frequencies) {
  uint32_t sum = 0;
  for (size_t bucket = 0; bucket < kDepthBuckets; ++bucket) {
    bucket_frequency[bucket] = frequencies[bucket];
    bucket_start[bucket] = static_cast<uint16_t>(sum);
    sum += frequencies[bucket];
  }
  bucket_start[kDepthBuckets] = static_cast<uint16_t>(sum);
  uint8_t bucket = 0;
  for (uint32_t i = 0; i < kDepthScale / kSlotsTogether; ++i) {
    while (i * kSlotsTogether >= bucket_start[bucket + 1]) ++bucket;
    bucket_of_slot[i] = bucket;
  }
}

}  // namespace vantage
