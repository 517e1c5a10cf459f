#pragma once

#include <cstdint>

#include "common/depth_codec/depth_kernels.h"
#include "common/depth_codec/depth_payload.h"
#include "common/depth_codec/symbol_frequencies.h"

namespace vantage {

/// Residuals beyond -2..2, lane by lane: few, where the values are steps of disparity. `Lanes` as
/// in LaneKernels.
template <class Lanes>
class EscapeKernels {
 public:
  using Words = typename Lanes::Words;
  using States = typename Lanes::States;

  [[gnu::noinline]] static void Append(uint32_t far, const Words& residual, TokenizeTask* task) {
    alignas(64) uint16_t values[32];
    Lanes::Store(residual, values);
    for (; far != 0; far &= far - 1) {
      task->escapes[task->num_escapes++] = values[__builtin_ctz(far)];
    }
  }

  [[gnu::noinline]] static void Encode(uint32_t far,
                                       const SymbolTable& table,
                                       States* states,
                                       uint16_t** words,
                                       const uint16_t** escapes) {
    alignas(64) uint32_t x[32];
    states->Store(x);
    for (; far != 0;) {
      const int lane = 31 - __builtin_clz(far);
      far ^= 1U << static_cast<uint32_t>(lane);
      const uint32_t distance = EscapeDistance(*--*escapes);
      const uint32_t bucket = EscapeBucket(distance);
      uint32_t state = Emptied(x[lane], uint64_t{x[lane]} >> (32U - bucket) != 0, words);
      state = (state << bucket) | (distance ^ (1U << bucket));
      const uint32_t frequency = table.bucket_frequency[bucket];
      state = Emptied(state, (state >> (32U - kDepthScaleBits)) >= frequency, words);
      x[lane] =
          ((state / frequency) << kDepthScaleBits) + state % frequency + table.bucket_start[bucket];
    }
    states->Load(x);
  }

  // What lies beyond -2..2: the lanes `far`; above 2 those of `above`.
  [[gnu::noinline]] static void Decode(uint32_t far,
                                       uint32_t above,
                                       States* states,
                                       const uint16_t** words,
                                       const SymbolTable& table,
                                       Words* residual) {
    alignas(64) uint32_t x[32];
    alignas(64) uint16_t values[32];
    states->Store(x);
    Lanes::Store(*residual, values);
    for (; far != 0; far &= far - 1) {
      const int lane = __builtin_ctz(far);
      uint32_t state = x[lane];
      const uint32_t slot = state & (kDepthScale - 1);
      uint32_t bucket = table.bucket_of_slot[slot / SymbolTable::kSlotsTogether];
      while (slot >= table.bucket_start[bucket + 1]) ++bucket;
      state = table.bucket_frequency[bucket] * (state >> kDepthScaleBits) + slot -
              table.bucket_start[bucket];
      state = Refilled(state, words);
      const uint32_t distance = (1U << bucket) | (state & ((1U << bucket) - 1U));
      x[lane] = Refilled(state >> bucket, words);
      const uint32_t magnitude = distance + 2U;
      values[lane] =
          static_cast<uint16_t>(((above >> lane) & 1U) != 0 ? magnitude : 0U - magnitude);
    }
    states->Load(x);
    *residual = Lanes::Load(values);
  }

 private:
  // Without branches, which would go either way by chance.
  [[gnu::always_inline]] static uint32_t Emptied(uint32_t state, bool full, uint16_t** words) {
    const uint32_t count = full ? 1 : 0;
    (*words)[-1] = static_cast<uint16_t>(state & 0xffffU);
    *words -= count;
    return state >> (16U * count);
  }
  [[gnu::always_inline]] static uint32_t Refilled(uint32_t state, const uint16_t** words) {
    const uint32_t count = state < kDepthStateLow ? 1 : 0;
    const uint32_t refilled = (state << 16U) | **words;
    *words += count;
    return count != 0 ? refilled : state;
  }
};

}  // namespace vantage
