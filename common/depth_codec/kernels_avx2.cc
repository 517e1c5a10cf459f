#include <immintrin.h>

#include <cstddef>
#include <cstdint>

#include "common/depth_codec/depth_kernels.h"
#include "common/depth_codec/lane_kernels.h"

namespace vantage {
namespace {

// Of eight lanes: how those of a mask are gathered at the end, and spread from the front.
struct LanePermutations {
  constexpr LanePermutations() {
    for (uint32_t mask = 0; mask < 256; ++mask) {
      uint8_t next = 0;
      for (uint8_t lane = 0; lane < 8; ++lane) {
        if (((mask >> lane) & 1U) != 0) spread[mask][lane] = next++;
      }
      next = 8;
      for (uint8_t lane = 8; lane-- > 0;) {
        if (((mask >> lane) & 1U) != 0) gather[mask][--next] = lane;
      }
    }
  }
  alignas(64) uint8_t gather[256][8] = {};
  alignas(64) uint8_t spread[256][8] = {};
};
constexpr LanePermutations kPermutations;

__m256i LoadPermutation(const uint8_t* lanes) {
  return _mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(lanes)));
}

__m256i Load256(const void* from) { return _mm256_loadu_si256(static_cast<const __m256i*>(from)); }

void Store256(const __m256i& a, void* to) { _mm256_storeu_si256(static_cast<__m256i*>(to), a); }

// Sixteen bytes in both halves, for lookups by _mm256_shuffle_epi8.
__m256i LoadBoth(const void* from) {
  return _mm256_broadcastsi128_si256(_mm_loadu_si128(static_cast<const __m128i*>(from)));
}

class Avx2Lanes {
 public:
  struct Words {
    __m256i low, high;
  };
  using Mask = Words;  // All bits of a lane, or none.

  Avx2Lanes() {
    alignas(16) uint8_t table[128] = {};
    for (size_t i = 0; i < 125; ++i) table[i] = kDepthGradientContexts[i];
    for (size_t i = 0; i < 8; ++i) gradient_[i] = LoadBoth(table + 16 * i);
    validity_ = LoadBoth(kDepthValidityContexts);
  }

  static void MarkValues(const uint16_t* depth, size_t size, size_t /*width*/, uint8_t* present) {
    MarkEachValue<Avx2Lanes>(depth, size, present);
  }

  static Words Load(const uint16_t* from) { return {Load256(from), Load256(from + 16)}; }
  static void Store(const Words& a, uint16_t* to) {
    Store256(a.low, to);
    Store256(a.high, to + 16);
  }
  static Words LoadBytes(const uint8_t* from) {
    return {_mm256_cvtepu8_epi16(_mm_loadu_si128(reinterpret_cast<const __m128i*>(from))),
            _mm256_cvtepu8_epi16(_mm_loadu_si128(reinterpret_cast<const __m128i*>(from + 16)))};
  }
  static void StoreBytes(const Words& a, uint8_t* to) {
    Store256(_mm256_permute4x64_epi64(_mm256_packus_epi16(a.low, a.high), 0xd8), to);
  }
  static Words Fill(int value) {
    const __m256i a = _mm256_set1_epi16(static_cast<int16_t>(value));
    return {a, a};
  }
  static Words Add(const Words& a, const Words& b) {
    return {_mm256_add_epi16(a.low, b.low), _mm256_add_epi16(a.high, b.high)};
  }
  static Words Sub(const Words& a, const Words& b) {
    return {_mm256_sub_epi16(a.low, b.low), _mm256_sub_epi16(a.high, b.high)};
  }
  static Words Min(const Words& a, const Words& b) {
    return {_mm256_min_epi16(a.low, b.low), _mm256_min_epi16(a.high, b.high)};
  }
  static Words Max(const Words& a, const Words& b) {
    return {_mm256_max_epi16(a.low, b.low), _mm256_max_epi16(a.high, b.high)};
  }
  template <int kBits>
  static Words ShiftLeft(const Words& a) {
    return {_mm256_slli_epi16(a.low, kBits), _mm256_slli_epi16(a.high, kBits)};
  }
  template <int kBits>
  static Words ShiftRight(const Words& a) {
    return {_mm256_srli_epi16(a.low, kBits), _mm256_srli_epi16(a.high, kBits)};
  }
  static Mask Equal(const Words& a, const Words& b) {
    return {_mm256_cmpeq_epi16(a.low, b.low), _mm256_cmpeq_epi16(a.high, b.high)};
  }
  static Mask IsNotZero(const Words& a) { return Not(Equal(a, Fill(0))); }
  static Mask IsNotBelow(const Words& a, const Words& b) {
    return Equal({_mm256_max_epu16(a.low, b.low), _mm256_max_epu16(a.high, b.high)}, a);
  }
  static Mask And(const Mask& a, const Mask& b) {
    return {_mm256_and_si256(a.low, b.low), _mm256_and_si256(a.high, b.high)};
  }
  static Mask Or(const Mask& a, const Mask& b) {
    return {_mm256_or_si256(a.low, b.low), _mm256_or_si256(a.high, b.high)};
  }
  static Mask Not(const Mask& a) {
    const __m256i ones = _mm256_set1_epi16(-1);
    return {_mm256_xor_si256(a.low, ones), _mm256_xor_si256(a.high, ones)};
  }
  static uint32_t Bits(const Mask& a) {
    const __m256i bytes = _mm256_packs_epi16(a.low, a.high);
    return static_cast<uint32_t>(_mm256_movemask_epi8(_mm256_permute4x64_epi64(bytes, 0xd8)));
  }
  static Mask FromBits(uint32_t bits) {
    const __m256i bit = _mm256_setr_epi16(1,
                                          1 << 1,
                                          1 << 2,
                                          1 << 3,
                                          1 << 4,
                                          1 << 5,
                                          1 << 6,
                                          1 << 7,
                                          1 << 8,
                                          1 << 9,
                                          1 << 10,
                                          1 << 11,
                                          1 << 12,
                                          1 << 13,
                                          1 << 14,
                                          static_cast<int16_t>(0x8000));
    const __m256i low = _mm256_set1_epi16(static_cast<int16_t>(bits & 0xffffU));
    const __m256i high = _mm256_set1_epi16(static_cast<int16_t>(bits >> 16U));
    return {_mm256_cmpeq_epi16(_mm256_and_si256(low, bit), bit),
            _mm256_cmpeq_epi16(_mm256_and_si256(high, bit), bit)};
  }
  static Words Select(const Mask& mask, const Words& a, const Words& b) {
    return {_mm256_blendv_epi8(b.low, a.low, mask.low),
            _mm256_blendv_epi8(b.high, a.high, mask.high)};
  }

  [[gnu::always_inline]] Words Context(const Words& index,
                                       const Mask& has_W,
                                       const Mask& has_N,
                                       const Mask& has_NW,
                                       const Mask& has_NE) const {
    // As bytes, in packus' order.
    const __m256i i = _mm256_packus_epi16(index.low, index.high);
    __m256i gradient = _mm256_setzero_si256();
    for (int part = 0; part < 8; ++part) {
      // 112..127 where the index is in this part, which looks up its low bits; else 128 and more,
      // which looks up 0.
      const __m256i in_part =
          _mm256_adds_epu8(_mm256_sub_epi8(i, _mm256_set1_epi8(static_cast<char>(16 * part))),
                           _mm256_set1_epi8(112));
      gradient = _mm256_or_si256(gradient, _mm256_shuffle_epi8(gradient_[part], in_part));
    }
    const __m256i W = _mm256_packs_epi16(has_W.low, has_W.high);
    const __m256i N = _mm256_packs_epi16(has_N.low, has_N.high);
    const __m256i NW = _mm256_packs_epi16(has_NW.low, has_NW.high);
    const __m256i NE = _mm256_packs_epi16(has_NE.low, has_NE.high);
    const __m256i validity =
        _mm256_or_si256(_mm256_or_si256(_mm256_and_si256(W, _mm256_set1_epi8(1)),
                                        _mm256_and_si256(N, _mm256_set1_epi8(2))),
                        _mm256_or_si256(_mm256_and_si256(NW, _mm256_set1_epi8(4)),
                                        _mm256_and_si256(NE, _mm256_set1_epi8(8))));
    const __m256i all = _mm256_and_si256(_mm256_and_si256(W, N), _mm256_and_si256(NW, NE));
    const __m256i context =
        _mm256_blendv_epi8(_mm256_shuffle_epi8(validity_, validity), gradient, all);
    const __m256i zero = _mm256_setzero_si256();
    return {_mm256_unpacklo_epi8(context, zero), _mm256_unpackhi_epi8(context, zero)};
  }

  // Of each symbol but the first the sum of frequencies below it, by context: low and high bytes.
  class Table {
   public:
    explicit Table(const SymbolTable& table) {
      for (size_t symbol = 1; symbol < kDepthSymbols; ++symbol) {
        uint8_t low_bytes[kDepthContexts];
        uint8_t high_bytes[kDepthContexts];
        for (size_t context = 0; context < kDepthContexts; ++context) {
          const uint32_t sum = table.start[context + kDepthContexts * symbol];
          low_bytes[context] = static_cast<uint8_t>(sum & 0xffU);
          high_bytes[context] = static_cast<uint8_t>(sum >> 8U);
        }
        low_[symbol] = LoadBoth(low_bytes);
        high_[symbol] = LoadBoth(high_bytes);
      }
    }

    // The sums of a symbol in sixteen contexts. Bytes are looked up: one half of each lane has the
    // context, the other one 128, which looks up 0.
    [[gnu::always_inline]] __m256i Below(size_t symbol, const __m256i& context) const {
      const __m256i for_low =
          _mm256_or_si256(context, _mm256_set1_epi16(static_cast<int16_t>(0x8000)));
      const __m256i for_high =
          _mm256_or_si256(_mm256_slli_epi16(context, 8), _mm256_set1_epi16(0x80));
      return _mm256_or_si256(_mm256_shuffle_epi8(low_[symbol], for_low),
                             _mm256_shuffle_epi8(high_[symbol], for_high));
    }

   private:
    __m256i low_[kDepthSymbols], high_[kDepthSymbols];
  };
  using EncodeTable = Table;
  using DecodeTable = Table;

  class States {
   public:
    void Load(const uint32_t* from) {
      for (size_t i = 0; i < 4; ++i) x_[i] = Load256(from + 8 * i);
    }
    void Store(uint32_t* to) const {
      for (size_t i = 0; i < 4; ++i) Store256(x_[i], to + 8 * i);
    }

    [[gnu::always_inline]] uint16_t* Encode(const EncodeTable& table,
                                            const Words& token,
                                            uint16_t* words) {
      words = EncodeHalf(table, token.high, words, &x_[2], &x_[3]);
      return EncodeHalf(table, token.low, words, &x_[0], &x_[1]);
    }

    [[gnu::always_inline]] Words Decode(const DecodeTable& table,
                                        const Words& context,
                                        const uint16_t** words) {
      const Words symbol = {DecodeHalf(table, context.low, words, &x_[0], &x_[1]),
                            DecodeHalf(table, context.high, words, &x_[2], &x_[3])};
      return symbol;
    }

   private:
    [[gnu::always_inline]] static uint16_t* EncodeHalf(const Table& table,
                                                       const __m256i& token,
                                                       uint16_t* words,
                                                       __m256i* states_low,
                                                       __m256i* states_high) {
      const __m256i context = _mm256_and_si256(token, _mm256_set1_epi16(15));
      const auto has = [&](int bit) {
        const __m256i it = _mm256_set1_epi16(static_cast<int16_t>(bit));
        return _mm256_cmpeq_epi16(_mm256_and_si256(token, it), it);
      };
      const __m256i has_1 = has(16);
      const __m256i has_2 = has(32);
      const __m256i has_4 = has(64);
      const auto choose = [&](const __m256i* of_8) {
        const __m256i from_0 = _mm256_blendv_epi8(_mm256_blendv_epi8(of_8[0], of_8[1], has_1),
                                                  _mm256_blendv_epi8(of_8[2], of_8[3], has_1),
                                                  has_2);
        const __m256i from_4 = _mm256_blendv_epi8(_mm256_blendv_epi8(of_8[4], of_8[5], has_1),
                                                  _mm256_blendv_epi8(of_8[6], of_8[7], has_1),
                                                  has_2);
        return _mm256_blendv_epi8(from_0, from_4, has_4);
      };
      __m256i sums[kDepthSymbols + 1];
      sums[0] = _mm256_setzero_si256();
      for (size_t symbol = 1; symbol < kDepthSymbols; ++symbol) {
        sums[symbol] = table.Below(symbol, context);
      }
      sums[kDepthSymbols] = _mm256_set1_epi16(static_cast<int16_t>(kDepthScale));
      const __m256i start = choose(sums);
      const __m256i frequency = _mm256_sub_epi16(choose(sums + 1), start);
      words = EncodeQuarter(_mm256_extracti128_si256(frequency, 1),
                            _mm256_extracti128_si256(start, 1),
                            words,
                            states_high);
      return EncodeQuarter(
          _mm256_castsi256_si128(frequency), _mm256_castsi256_si128(start), words, states_low);
    }

    // 2^14 * floor(x / f) + x mod f + start. The quotient is below 2^18: in single precision it is
    // right or off by one.
    [[gnu::always_inline]] static uint16_t* EncodeQuarter(const __m128i& frequencies,
                                                          const __m128i& starts,
                                                          uint16_t* words,
                                                          __m256i* states) {
      const __m256i low_half = _mm256_set1_epi32(0xffff);
      const __m256i f = _mm256_cvtepu16_epi32(frequencies);
      const __m256i start = _mm256_cvtepu16_epi32(starts);
      __m256i x = *states;
      // As signed numbers: both sides are small.
      const __m256i keep = _mm256_cmpgt_epi32(f, _mm256_srli_epi32(x, 32 - kDepthScaleBits));
      const auto full =
          static_cast<uint32_t>(_mm256_movemask_ps(_mm256_castsi256_ps(keep))) ^ 0xffU;
      StoreBack(_mm256_permutevar8x32_epi32(x, LoadPermutation(kPermutations.gather[full])), words);
      words -= __builtin_popcount(full);
      x = _mm256_blendv_epi8(_mm256_srli_epi32(x, 16), x, keep);
      const __m256 value = _mm256_add_ps(
          _mm256_mul_ps(_mm256_cvtepi32_ps(_mm256_srli_epi32(x, 16)), _mm256_set1_ps(65536.0F)),
          _mm256_cvtepi32_ps(_mm256_and_si256(x, low_half)));
      const __m256i quotient = _mm256_cvttps_epi32(_mm256_div_ps(value, _mm256_cvtepi32_ps(f)));
      const __m256i rest = _mm256_sub_epi32(x, _mm256_mullo_epi32(quotient, f));
      const __m256i one_less = _mm256_srai_epi32(rest, 31);
      const __m256i one_more = _mm256_cmpgt_epi32(rest, _mm256_sub_epi32(f, _mm256_set1_epi32(1)));
      const __m256i step = _mm256_sub_epi32(_mm256_set1_epi32(static_cast<int>(kDepthScale)), f);
      __m256i next = _mm256_add_epi32(_mm256_slli_epi32(quotient, kDepthScaleBits),
                                      _mm256_add_epi32(rest, start));
      next = _mm256_add_epi32(next, _mm256_and_si256(step, one_more));
      *states = _mm256_sub_epi32(next, _mm256_and_si256(step, one_less));
      return words;
    }

    // The low words of all lanes before `words`. The first ones may be none that count: the next
    // ones go over them.
    [[gnu::always_inline]] static void StoreBack(const __m256i& lanes, uint16_t* words) {
      const __m256i low = _mm256_and_si256(lanes, _mm256_set1_epi32(0xffff));
      const __m256i packed = _mm256_permute4x64_epi64(_mm256_packus_epi32(low, low), 0x08);
      _mm_storeu_si128(reinterpret_cast<__m128i*>(words - 8), _mm256_castsi256_si128(packed));
    }

    [[gnu::always_inline]] static __m256i DecodeHalf(const DecodeTable& table,
                                                     const __m256i& context,
                                                     const uint16_t** words,
                                                     __m256i* states_low,
                                                     __m256i* states_high) {
      const auto below = [&](size_t symbol) { return table.Below(symbol, context); };
      const __m256i slot_mask = _mm256_set1_epi32(static_cast<int>(kDepthScale - 1));
      const __m256i slot =
          _mm256_permute4x64_epi64(_mm256_packus_epi32(_mm256_and_si256(*states_low, slot_mask),
                                                       _mm256_and_si256(*states_high, slot_mask)),
                                   0xd8);
      // Masks of what is below; all numbers are below 2^15.
      const __m256i pivot_4 = below(4);
      const __m256i is_below_4 = _mm256_cmpgt_epi16(pivot_4, slot);
      const __m256i pivot_2 = _mm256_blendv_epi8(below(6), below(2), is_below_4);
      const __m256i is_below_2 = _mm256_cmpgt_epi16(pivot_2, slot);
      const __m256i pivot_1 = _mm256_blendv_epi8(_mm256_blendv_epi8(below(7), below(3), is_below_4),
                                                 _mm256_blendv_epi8(below(5), below(1), is_below_4),
                                                 is_below_2);
      const __m256i is_below_1 = _mm256_cmpgt_epi16(pivot_1, slot);

      __m256i start = _mm256_andnot_si256(is_below_4, pivot_4);
      start = _mm256_blendv_epi8(pivot_2, start, is_below_2);
      start = _mm256_blendv_epi8(pivot_1, start, is_below_1);
      __m256i end = _mm256_blendv_epi8(
          _mm256_set1_epi16(static_cast<int16_t>(kDepthScale)), pivot_4, is_below_4);
      end = _mm256_blendv_epi8(end, pivot_2, is_below_2);
      end = _mm256_blendv_epi8(end, pivot_1, is_below_1);
      // 7 less 4, 2 and 1 where below.
      const __m256i less =
          _mm256_add_epi16(_mm256_add_epi16(_mm256_slli_epi16(is_below_4, 2), is_below_1),
                           _mm256_slli_epi16(is_below_2, 1));

      const __m256i frequency = _mm256_sub_epi16(end, start);
      const __m256i offset = _mm256_sub_epi16(slot, start);
      DecodeQuarter(
          _mm256_castsi256_si128(frequency), _mm256_castsi256_si128(offset), words, states_low);
      DecodeQuarter(_mm256_extracti128_si256(frequency, 1),
                    _mm256_extracti128_si256(offset, 1),
                    words,
                    states_high);
      return _mm256_add_epi16(_mm256_set1_epi16(7), less);
    }

    [[gnu::always_inline]] static void DecodeQuarter(const __m128i& frequencies,
                                                     const __m128i& offsets,
                                                     const uint16_t** words,
                                                     __m256i* states) {
      __m256i x = _mm256_mullo_epi32(_mm256_cvtepu16_epi32(frequencies),
                                     _mm256_srli_epi32(*states, kDepthScaleBits));
      x = _mm256_add_epi32(x, _mm256_cvtepu16_epi32(offsets));
      const __m256i low = _mm256_cmpeq_epi32(_mm256_srli_epi32(x, 16), _mm256_setzero_si256());
      const auto mask = static_cast<uint32_t>(_mm256_movemask_ps(_mm256_castsi256_ps(low)));
      const __m256i next = _mm256_permutevar8x32_epi32(
          _mm256_cvtepu16_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(*words))),
          LoadPermutation(kPermutations.spread[mask]));
      *states = _mm256_blendv_epi8(x, _mm256_or_si256(_mm256_slli_epi32(x, 16), next), low);
      *words += __builtin_popcount(mask);
    }

    __m256i x_[4];
  };

 private:
  __m256i gradient_[8];
  __m256i validity_;
};

using Kernels = LaneKernels<Avx2Lanes>;

}  // namespace

const DepthKernels kAvx2DepthKernels = {
    "avx2", Avx2Lanes::MarkValues, Kernels::Tokenize, Kernels::Encode, Kernels::Decode};

}  // namespace vantage
