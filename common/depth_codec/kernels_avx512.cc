#include <immintrin.h>

#include <cstddef>
#include <cstdint>

#include "common/depth_codec/depth_kernels.h"
#include "common/depth_codec/lane_kernels.h"

namespace vantage {
namespace {

// Needs AVX-512 F, BW, VL, DQ and VBMI2.
class Avx512Lanes {
 public:
  using Words = __m512i;
  using Mask = __mmask32;

  Avx512Lanes() {
    alignas(64) uint16_t table[128 + 32] = {};
    for (size_t i = 0; i < 125; ++i) table[i] = kDepthGradientContexts[i];
    for (size_t i = 0; i < 16; ++i) table[128 + i] = kDepthValidityContexts[i];
    for (size_t i = 0; i < 4; ++i) gradient_[i] = Load(table + 32 * i);
    validity_ = Load(table + 128);
  }

  // Most pixels have the value of one before them, which need not be marked again; the others are
  // collected first.
  static void MarkValues(const uint16_t* depth, size_t size, size_t width, uint8_t* present) {
    constexpr size_t kCollected = 1024;
    uint16_t collected[kCollected + 32];
    size_t count = 0;
    // Where the pixel right of the one above comes before the one in hand.
    size_t i = width > 1 && width < size ? width : size;
    MarkEachValue<Avx512Lanes>(depth, i, present);
    for (; i + 32 <= size; i += 32) {
      const Words value = Load(depth + i);
      const Mask is_new = _mm512_cmpneq_epi16_mask(value, Load(depth + i - 1)) &
                          _mm512_cmpneq_epi16_mask(value, Load(depth + i - width)) &
                          _mm512_cmpneq_epi16_mask(value, Load(depth + i - width + 1));
      Store(_mm512_maskz_compress_epi16(is_new, value), collected + count);
      count += static_cast<size_t>(__builtin_popcount(is_new));
      if (count < kCollected) continue;
      MarkEachValue<Avx512Lanes>(collected, count, present);
      count = 0;
    }
    MarkEachValue<Avx512Lanes>(collected, count, present);
    MarkEachValue<Avx512Lanes>(depth + i, size - i, present);
  }

  static Words Load(const uint16_t* from) { return _mm512_loadu_si512(from); }
  static void Store(const Words& a, uint16_t* to) { _mm512_storeu_si512(to, a); }
  static Words LoadBytes(const uint8_t* from) {
    return _mm512_cvtepu8_epi16(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(from)));
  }
  static void StoreBytes(const Words& a, uint8_t* to) {
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), _mm512_cvtepi16_epi8(a));
  }
  static Words Fill(int value) { return _mm512_set1_epi16(static_cast<int16_t>(value)); }
  static Words Add(const Words& a, const Words& b) { return _mm512_add_epi16(a, b); }
  static Words Sub(const Words& a, const Words& b) { return _mm512_sub_epi16(a, b); }
  static Words Min(const Words& a, const Words& b) { return _mm512_min_epi16(a, b); }
  static Words Max(const Words& a, const Words& b) { return _mm512_max_epi16(a, b); }
  template <int kBits>
  static Words ShiftLeft(const Words& a) {
    return _mm512_slli_epi16(a, kBits);
  }
  template <int kBits>
  static Words ShiftRight(const Words& a) {
    return _mm512_srli_epi16(a, kBits);
  }
  static Mask Equal(const Words& a, const Words& b) { return _mm512_cmpeq_epi16_mask(a, b); }
  static Mask IsNotZero(const Words& a) { return _mm512_test_epi16_mask(a, a); }
  static Mask IsNotBelow(const Words& a, const Words& b) { return _mm512_cmpge_epu16_mask(a, b); }
  static Mask And(Mask a, Mask b) { return a & b; }
  static Mask Or(Mask a, Mask b) { return a | b; }
  static Mask Not(Mask a) { return ~a; }
  static uint32_t Bits(Mask a) { return a; }
  static Mask FromBits(uint32_t bits) { return bits; }
  static Words Select(Mask mask, const Words& a, const Words& b) {
    return _mm512_mask_blend_epi16(mask, b, a);
  }

  [[gnu::always_inline]] Words Context(
      const Words& index, Mask has_W, Mask has_N, Mask has_NW, Mask has_NE) const {
    const Words low = _mm512_permutex2var_epi16(gradient_[0], index, gradient_[1]);
    const Words high = _mm512_permutex2var_epi16(gradient_[2], index, gradient_[3]);
    const Mask is_high = _mm512_test_epi16_mask(index, Fill(64));
    Words validity = _mm512_maskz_mov_epi16(has_W, Fill(1));
    validity = _mm512_mask_add_epi16(validity, has_N, validity, Fill(2));
    validity = _mm512_mask_add_epi16(validity, has_NW, validity, Fill(4));
    validity = _mm512_mask_add_epi16(validity, has_NE, validity, Fill(8));
    const Words other = _mm512_permutexvar_epi16(validity, validity_);
    return Select(has_W & has_N & has_NW & has_NE, Select(is_high, high, low), other);
  }

  struct EncodeTable {
    explicit EncodeTable(const SymbolTable& table) {
      for (size_t i = 0; i < 4; ++i) {
        frequency[i] = Load(table.frequency + 32 * i);
        start[i] = Load(table.start + 32 * i);
      }
    }
    Words frequency[4], start[4];
  };

  // The sums of frequencies below symbol 4, below 2 and 6, and below 1, 5, 3 and 7.
  struct DecodeTable {
    explicit DecodeTable(const SymbolTable& table) {
      alignas(64) uint16_t sums[4 * 32] = {};
      for (size_t context = 0; context < kDepthContexts; ++context) {
        const auto below = [&](size_t symbol) {
          return table.start[context + kDepthContexts * symbol];
        };
        sums[context] = below(4);
        sums[32 + context] = below(2);
        sums[48 + context] = below(6);
        sums[64 + context] = below(1);
        sums[80 + context] = below(5);
        sums[96 + context] = below(3);
        sums[112 + context] = below(7);
      }
      below_4 = Load(sums);
      below_2_6 = Load(sums + 32);
      below_1_5 = Load(sums + 64);
      below_3_7 = Load(sums + 96);
    }
    Words below_4, below_2_6, below_1_5, below_3_7;
  };

  class States {
   public:
    void Load(const uint32_t* from) {
      low_ = _mm512_loadu_si512(from);
      high_ = _mm512_loadu_si512(from + 16);
    }
    void Store(uint32_t* to) const {
      _mm512_storeu_si512(to, low_);
      _mm512_storeu_si512(to + 16, high_);
    }

    [[gnu::always_inline]] uint16_t* Encode(const EncodeTable& table,
                                            const Words& token,
                                            uint16_t* words) {
      const Mask is_high = _mm512_test_epi16_mask(token, Fill(64));
      const Words frequency =
          Select(is_high,
                 _mm512_permutex2var_epi16(table.frequency[2], token, table.frequency[3]),
                 _mm512_permutex2var_epi16(table.frequency[0], token, table.frequency[1]));
      const Words start = Select(is_high,
                                 _mm512_permutex2var_epi16(table.start[2], token, table.start[3]),
                                 _mm512_permutex2var_epi16(table.start[0], token, table.start[1]));
      const __m512i low_f = _mm512_cvtepu16_epi32(_mm512_castsi512_si256(frequency));
      const __m512i high_f = _mm512_cvtepu16_epi32(_mm512_extracti64x4_epi64(frequency, 1));
      const __mmask16 low_full = IsFull(low_, low_f);
      const __mmask16 high_full = IsFull(high_, high_f);
      const Mask full = _mm512_kunpackw(high_full, low_full);
      const auto count = static_cast<uint32_t>(__builtin_popcount(full));
      words -= count;
      _mm512_mask_storeu_epi16(words,
                               static_cast<Mask>((uint64_t{1} << count) - 1U),
                               _mm512_maskz_compress_epi16(full, LowWords()));
      low_ = Encoded(_mm512_mask_srli_epi32(low_, low_full, low_, 16),
                     low_f,
                     _mm512_cvtepu16_epi32(_mm512_castsi512_si256(start)));
      high_ = Encoded(_mm512_mask_srli_epi32(high_, high_full, high_, 16),
                      high_f,
                      _mm512_cvtepu16_epi32(_mm512_extracti64x4_epi64(start, 1)));
      return words;
    }

    [[gnu::always_inline]] Words Decode(const DecodeTable& table,
                                        const Words& context,
                                        const uint16_t** words) {
      const Words slot = _mm512_and_si512(LowWords(), Fill(kDepthScale - 1));
      const Words pivot_4 = _mm512_permutexvar_epi16(context, table.below_4);
      const Mask not_below_4 = _mm512_cmpge_epu16_mask(slot, pivot_4);
      const Words index_2 = _mm512_mask_add_epi16(context, not_below_4, context, Fill(16));
      const Words pivot_2 = _mm512_permutexvar_epi16(index_2, table.below_2_6);
      const Mask not_below_2 = _mm512_cmpge_epu16_mask(slot, pivot_2);
      const Words index_1 = _mm512_mask_add_epi16(index_2, not_below_2, index_2, Fill(32));
      const Words pivot_1 = _mm512_permutex2var_epi16(table.below_1_5, index_1, table.below_3_7);
      const Mask not_below_1 = _mm512_cmpge_epu16_mask(slot, pivot_1);

      Words start = _mm512_maskz_mov_epi16(not_below_4, pivot_4);
      start = Select(not_below_2, pivot_2, start);
      start = Select(not_below_1, pivot_1, start);
      Words end = Select(not_below_4, Fill(kDepthScale), pivot_4);
      end = Select(not_below_2, end, pivot_2);
      end = Select(not_below_1, end, pivot_1);
      Words symbol = _mm512_maskz_mov_epi16(not_below_4, Fill(4));
      symbol = _mm512_mask_add_epi16(symbol, not_below_2, symbol, Fill(2));
      symbol = _mm512_mask_add_epi16(symbol, not_below_1, symbol, Fill(1));

      const Words frequency = Sub(end, start);
      const Words offset = Sub(slot, start);
      const __m512i low = Decoded(low_,
                                  _mm512_cvtepu16_epi32(_mm512_castsi512_si256(frequency)),
                                  _mm512_cvtepu16_epi32(_mm512_castsi512_si256(offset)));
      const __m512i high = Decoded(high_,
                                   _mm512_cvtepu16_epi32(_mm512_extracti64x4_epi64(frequency, 1)),
                                   _mm512_cvtepu16_epi32(_mm512_extracti64x4_epi64(offset, 1)));
      const __mmask16 low_empty = _mm512_cmplt_epu32_mask(low, _mm512_set1_epi32(kDepthStateLow));
      const __mmask16 high_empty = _mm512_cmplt_epu32_mask(high, _mm512_set1_epi32(kDepthStateLow));
      const Mask empty = _mm512_kunpackw(high_empty, low_empty);
      const Words next = _mm512_maskz_expand_epi16(empty, Avx512Lanes::Load(*words));
      *words += __builtin_popcount(empty);
      low_ = _mm512_or_si512(_mm512_mask_slli_epi32(low, low_empty, low, 16),
                             _mm512_cvtepu16_epi32(_mm512_castsi512_si256(next)));
      high_ = _mm512_or_si512(_mm512_mask_slli_epi32(high, high_empty, high, 16),
                              _mm512_cvtepu16_epi32(_mm512_extracti64x4_epi64(next, 1)));
      return symbol;
    }

   private:
    [[gnu::always_inline]] Words LowWords() const {
      alignas(64) static constexpr uint16_t kEven[32] = {0,  2,  4,  6,  8,  10, 12, 14, 16, 18, 20,
                                                         22, 24, 26, 28, 30, 32, 34, 36, 38, 40, 42,
                                                         44, 46, 48, 50, 52, 54, 56, 58, 60, 62};
      return _mm512_permutex2var_epi16(low_, Avx512Lanes::Load(kEven), high_);
    }

    [[gnu::always_inline]] static __mmask16 IsFull(const __m512i& x, const __m512i& f) {
      return _mm512_cmpge_epu32_mask(_mm512_srli_epi32(x, 32 - kDepthScaleBits), f);
    }

    // 2^14 * floor(x / f) + x mod f + start. The quotient is below 2^18: rounded down in single
    // precision it is right or one too small.
    [[gnu::always_inline]] static __m512i Encoded(const __m512i& x,
                                                  const __m512i& f,
                                                  const __m512i& start) {
      constexpr int kDown = _MM_FROUND_TO_ZERO | _MM_FROUND_NO_EXC;
      const __m512 ratio = _mm512_div_round_ps(
          _mm512_cvt_roundepu32_ps(x, kDown), _mm512_cvt_roundepu32_ps(f, kDown), kDown);
      const __m512i quotient = _mm512_cvttps_epi32(ratio);
      const __m512i rest = _mm512_sub_epi32(x, _mm512_mullo_epi32(quotient, f));
      const __mmask16 one_more = _mm512_cmpge_epi32_mask(rest, f);
      const __m512i base = _mm512_add_epi32(_mm512_slli_epi32(quotient, kDepthScaleBits),
                                            _mm512_add_epi32(rest, start));
      return _mm512_mask_add_epi32(
          base,
          one_more,
          base,
          _mm512_sub_epi32(_mm512_set1_epi32(static_cast<int>(kDepthScale)), f));
    }

    [[gnu::always_inline]] static __m512i Decoded(const __m512i& x,
                                                  const __m512i& frequency,
                                                  const __m512i& offset) {
      return _mm512_add_epi32(_mm512_mullo_epi32(frequency, _mm512_srli_epi32(x, kDepthScaleBits)),
                              offset);
    }

    __m512i low_, high_;
  };

 private:
  Words gradient_[4];
  Words validity_;
};

using Kernels = LaneKernels<Avx512Lanes>;

}  // namespace

const DepthKernels kAvx512DepthKernels = {
    "avx512", Avx512Lanes::MarkValues, Kernels::Tokenize, Kernels::Encode, Kernels::Decode};

}  // namespace vantage
