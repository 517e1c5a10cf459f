#pragma once

#include <cstddef>
#include <cstdint>

#include "common/depth_codec/depth_kernels.h"
#include "common/depth_codec/depth_payload.h"
#include "common/depth_codec/escape_kernels.h"
#include "common/depth_codec/pixel_neighbors.h"
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
      if (far != 0) Escapes::Append(far, residual, task);
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
        if (far != 0)
          Escapes::Encode(far, *task->table, &states[band], &words, &task->escapes[band]);
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

  using Neighbors = PixelNeighbors<Lanes>;
  using Escapes = EscapeKernels<Lanes>;

  [[gnu::always_inline]] static Mask IsFar(const Words& symbol) {
    return Lanes::Or(Lanes::Equal(symbol, Lanes::Fill(kDepthSymbolBelow)),
                     Lanes::Equal(symbol, Lanes::Fill(kDepthSymbolAbove)));
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
          Escapes::Decode(far, Lanes::Bits(above), &states[band], &words, *task->table, &residual);
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
