#pragma once

#include <cstddef>
#include <cstdint>

#include "common/depth_codec/depth_kernels.h"
#include "common/depth_codec/depth_payload.h"
#include "common/depth_codec/symbol_frequencies.h"

namespace vantage {

template <class Lanes>
void MarkEachValue(const uint16_t* depth, size_t size, uint8_t* present) {
  for (size_t i = 0; i < size; ++i) present[depth[i]] = 1;
}

/// The depth codec's loops for one instruction set. `Lanes` has 32 lanes of 16 bits (Words), a
/// truth value for each (Mask), 32 range coder states (States), and the operations on them; it
/// lives in an unnamed namespace, so that what is compiled here for one instruction set is never
/// linked into what runs on another. For the same reason nothing of the standard library that is
/// not inlined for sure is called.
template <class Lanes>
class LaneKernels {
 public:
  static void Tokenize(TokenizeTask* task) {
    const Lanes lanes;
    Neighbors near;
    near.Begin(task->above);
    for (size_t column = 0; column < task->columns; ++column) {
      near.Advance(task->above, column);
      const Words rank = Lanes::Load(task->ranks + 32 * column);
      const Mask valid = Lanes::IsNotZero(rank);
      const Words predicted = near.Predicted();
      const Words context = near.Context(lanes);
      const Words residual = Lanes::Sub(rank, predicted);
      const Words near_residual = Lanes::Min(Lanes::Max(residual, Lanes::Fill(-kDepthSymbolOfZero)),
                                             Lanes::Fill(kDepthSymbolAbove - kDepthSymbolOfZero));
      const Words symbol = Lanes::Select(valid,
                                         Lanes::Add(near_residual, Lanes::Fill(kDepthSymbolOfZero)),
                                         Lanes::Fill(kDepthSymbolInvalid));
      Lanes::StoreBytes(Lanes::Add(context, Lanes::template ShiftLeft<4>(symbol)),
                        task->tokens + DepthLayout::kLanes * column);
      const uint32_t far = Lanes::Bits(valid) & Lanes::Bits(IsFar(symbol));
      if (far != 0) AppendEscapes(far, residual, task);
      near.Keep(Lanes::Select(valid, rank, predicted), valid, task->row, column);
    }
  }

  static void Encode(EncodeTask* task) {
    const typename Lanes::EncodeTable table(*task->table);
    States states[DepthLayout::kBands];
    for (size_t band = 0; band < task->bands; ++band) states[band].Load(task->states + 32 * band);
    uint16_t* words = task->words;
    for (size_t column = task->columns; column-- > 0;) {
      for (size_t band = task->bands; band-- > 0;) {
        const Words token =
            Lanes::LoadBytes(task->tokens + DepthLayout::kLanes * column + 32 * band);
        const Words symbol = Lanes::template ShiftRight<4>(token);
        const uint32_t far = Lanes::Bits(IsFar(symbol));
        if (far != 0) EncodeEscapes(far, *task->table, &states[band], &words, &task->escapes[band]);
        words = states[band].Encode(table, token, words);
      }
    }
    for (size_t band = 0; band < task->bands; ++band) states[band].Store(task->states + 32 * band);
    task->words = words;
  }

  static void Decode(DecodeTask* task) {
    if (task->bands == 2) {
      DecodeBands<2>(task);
    } else {
      DecodeBands<1>(task);
    }
  }

 private:
  using Words = typename Lanes::Words;
  using Mask = typename Lanes::Mask;
  using States = typename Lanes::States;

  // What is known around a pixel: W its left neighbour, N the one above.
  class Neighbors {
   public:
    // Left of a strip's first column lies another strip, of which only the row above is known.
    [[gnu::always_inline]] void Begin(const DepthRowView& above) {
      W_ = Lanes::Load(above.ranks);
      N_ = W_;
      NE_ = Lanes::Load(above.ranks + 32);
      has_W_ = Lanes::FromBits(above.valid[0]);
      has_N_ = has_W_;
      has_NE_ = Lanes::FromBits(above.valid[1]);
    }

    [[gnu::always_inline]] void Advance(const DepthRowView& above, size_t column) {
      NW_ = N_;
      N_ = NE_;
      NE_ = Lanes::Load(above.ranks + 32 * (column + 2));
      has_NW_ = has_N_;
      has_N_ = has_NE_;
      has_NE_ = Lanes::FromBits(above.valid[column + 2]);
    }

    // The median of W, N and W + N - NW (LOCO-I).
    [[gnu::always_inline]] Words Predicted() const {
      const Words plane = Lanes::Add(W_, Lanes::Sub(N_, NW_));
      return Lanes::Max(Lanes::Min(W_, N_), Lanes::Min(plane, Lanes::Max(W_, N_)));
    }

    [[gnu::always_inline]] Words Context(const Lanes& lanes) const {
      const Words g3 = Clamped(Lanes::Sub(NE_, N_));
      const Words g2 = Clamped(Lanes::Sub(N_, NW_));
      const Words g23 = Lanes::Add(Lanes::Add(g3, Lanes::template ShiftLeft<2>(g3)), g2);
      const Words rest = Lanes::Add(Lanes::Add(g23, Lanes::template ShiftLeft<2>(g23)),
                                    Lanes::Fill(2 * (25 + 5 + 1)));
      const Words index = Lanes::Add(rest, Clamped(Lanes::Sub(W_, NW_)));
      return lanes.Context(index, has_W_, has_N_, has_NW_, has_NE_);
    }

    [[gnu::always_inline]] void Keep(const Words& rank,
                                     const Mask& valid,
                                     const DepthRowView& row,
                                     size_t column) {
      W_ = rank;
      has_W_ = valid;
      Lanes::Store(rank, row.ranks + 32 * (column + 1));
      row.valid[column + 1] = Lanes::Bits(valid);
    }

   private:
    [[gnu::always_inline]] static Words Clamped(const Words& step) {
      return Lanes::Min(Lanes::Max(step, Lanes::Fill(-2)), Lanes::Fill(2));
    }

    Words W_, NW_, N_, NE_;
    Mask has_W_, has_NW_, has_N_, has_NE_;
  };

  [[gnu::always_inline]] static Mask IsFar(const Words& symbol) {
    return Lanes::Or(Lanes::Equal(symbol, Lanes::Fill(kDepthSymbolBelow)),
                     Lanes::Equal(symbol, Lanes::Fill(kDepthSymbolAbove)));
  }

  [[gnu::noinline]] static void AppendEscapes(uint32_t far,
                                              const Words& residual,
                                              TokenizeTask* task) {
    alignas(64) uint16_t values[32];
    Lanes::Store(residual, values);
    for (; far != 0; far &= far - 1) {
      task->escapes[task->num_escapes++] = values[__builtin_ctz(far)];
    }
  }

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

  [[gnu::noinline]] static void EncodeEscapes(uint32_t far,
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
  [[gnu::noinline]] static void DecodeEscapes(uint32_t far,
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

  template <size_t kBands>
  static void DecodeBands(DecodeTask* task) {
    const Lanes lanes;
    const typename Lanes::DecodeTable table(*task->table);
    const Words num_ranks = Lanes::Fill(static_cast<int>(task->num_ranks));
    Mask beyond = Lanes::FromBits(0);
    const uint16_t* words = task->words;
    States states[kBands];
    Neighbors near[kBands];
    for (size_t band = 0; band < kBands; ++band) {
      states[band].Load(task->states + 32 * band);
      near[band].Begin(task->above[band]);
    }
    for (size_t column = 0; column < task->columns; ++column) {
      for (size_t band = 0; band < kBands; ++band) {
        near[band].Advance(task->above[band], column);
        const Words symbol = states[band].Decode(table, near[band].Context(lanes), &words);
        Words residual = Lanes::Sub(symbol, Lanes::Fill(kDepthSymbolOfZero));
        const Mask invalid = Lanes::Equal(symbol, Lanes::Fill(kDepthSymbolInvalid));
        const uint32_t far = Lanes::Bits(IsFar(symbol));
        if (far != 0) {
          const Mask above = Lanes::Equal(symbol, Lanes::Fill(kDepthSymbolAbove));
          DecodeEscapes(far, Lanes::Bits(above), &states[band], &words, *task->table, &residual);
        }
        const Words predicted = near[band].Predicted();
        const Words rank = Lanes::Add(predicted, residual);
        const Mask valid = Lanes::Not(invalid);
        beyond = Lanes::Or(
            beyond,
            Lanes::And(valid, Lanes::IsNotBelow(Lanes::Sub(rank, Lanes::Fill(1)), num_ranks)));
        Lanes::Store(Lanes::Select(valid, rank, Lanes::Fill(0)), task->ranks[band] + 32 * column);
        near[band].Keep(Lanes::Select(valid, rank, predicted), valid, task->row[band], column);
      }
    }
    for (size_t band = 0; band < kBands; ++band) states[band].Store(task->states + 32 * band);
    task->words = words;
    if (Lanes::Bits(beyond) != 0) task->sound = false;
  }
};

}  // namespace vantage
