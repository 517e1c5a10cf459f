#pragma once

#include <cstddef>

#include "common/depth_codec/depth_kernels.h"

namespace vantage {

/// What is known around a pixel: W its left neighbour, N the one above. `Lanes` as in LaneKernels.
template <class Lanes>
class PixelNeighbors {
 public:
  using Words = typename Lanes::Words;
  using Mask = typename Lanes::Mask;

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

}  // namespace vantage
