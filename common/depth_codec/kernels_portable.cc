#include <cstddef>
#include <cstdint>
#include <cstring>

#include "common/depth_codec/depth_kernels.h"
#include "common/depth_codec/lane_kernels.h"

namespace vantage {
namespace {

// For any processor: loops over lanes.
class PortableLanes {
 public:
  struct Words {
    int16_t lanes[32];
  };
  using Mask = uint32_t;

  static void MarkValues(const uint16_t* depth, size_t size, size_t /*width*/, uint8_t* present) {
    MarkEachValue<PortableLanes>(depth, size, present);
  }

  static Words Load(const uint16_t* from) {
    Words a;
    std::memcpy(a.lanes, from, sizeof(a.lanes));
    return a;
  }
  static void Store(const Words& a, uint16_t* to) { std::memcpy(to, a.lanes, sizeof(a.lanes)); }
  static Words LoadBytes(const uint8_t* from) {
    return Make([&](size_t i) { return int{from[i]}; });
  }
  static void StoreBytes(const Words& a, uint8_t* to) {
    for (size_t i = 0; i < 32; ++i) to[i] = static_cast<uint8_t>(a.lanes[i]);
  }
  static Words Fill(int value) {
    return Make([&](size_t) { return value; });
  }
  static Words Add(const Words& a, const Words& b) {
    return Make([&](size_t i) { return a.lanes[i] + b.lanes[i]; });
  }
  static Words Sub(const Words& a, const Words& b) {
    return Make([&](size_t i) { return a.lanes[i] - b.lanes[i]; });
  }
  static Words Min(const Words& a, const Words& b) {
    return Make([&](size_t i) { return a.lanes[i] < b.lanes[i] ? a.lanes[i] : b.lanes[i]; });
  }
  static Words Max(const Words& a, const Words& b) {
    return Make([&](size_t i) { return a.lanes[i] > b.lanes[i] ? a.lanes[i] : b.lanes[i]; });
  }
  template <int kBits>
  static Words ShiftLeft(const Words& a) {
    return Make([&](size_t i) { return a.lanes[i] * (1 << kBits); });
  }
  template <int kBits>
  static Words ShiftRight(const Words& a) {
    return Make([&](size_t i) { return static_cast<uint16_t>(a.lanes[i]) >> kBits; });
  }
  static Mask Equal(const Words& a, const Words& b) {
    return Where([&](size_t i) { return a.lanes[i] == b.lanes[i]; });
  }
  static Mask IsNotZero(const Words& a) {
    return Where([&](size_t i) { return a.lanes[i] != 0; });
  }
  static Mask IsNotBelow(const Words& a, const Words& b) {
    return Where([&](size_t i) {
      return static_cast<uint16_t>(a.lanes[i]) >= static_cast<uint16_t>(b.lanes[i]);
    });
  }
  static Mask And(Mask a, Mask b) { return a & b; }
  static Mask Or(Mask a, Mask b) { return a | b; }
  static Mask Not(Mask a) { return ~a; }
  static uint32_t Bits(Mask a) { return a; }
  static Mask FromBits(uint32_t bits) { return bits; }
  static Words Select(Mask mask, const Words& a, const Words& b) {
    return Make([&](size_t i) { return Bit(mask, i) != 0 ? a.lanes[i] : b.lanes[i]; });
  }

  static Words Context(const Words& index, Mask has_W, Mask has_N, Mask has_NW, Mask has_NE) {
    return Make([&](size_t i) {
      const uint32_t validity =
          Bit(has_W, i) + 2 * Bit(has_N, i) + 4 * Bit(has_NW, i) + 8 * Bit(has_NE, i);
      return validity == 15 ? int{kDepthGradientContexts[static_cast<size_t>(index.lanes[i])]}
                            : int{kDepthValidityContexts[validity]};
    });
  }

  using EncodeTable = const SymbolTable&;
  using DecodeTable = const SymbolTable&;

  class States {
   public:
    void Load(const uint32_t* from) { std::memcpy(x_, from, sizeof(x_)); }
    void Store(uint32_t* to) const { std::memcpy(to, x_, sizeof(x_)); }

    uint16_t* Encode(const SymbolTable& table, const Words& token, uint16_t* words) {
      for (size_t i = 32; i-- > 0;) {
        const auto index = static_cast<size_t>(token.lanes[i]);
        const uint32_t frequency = table.frequency[index];
        if ((x_[i] >> (32U - kDepthScaleBits)) >= frequency) {
          *--words = static_cast<uint16_t>(x_[i] & 0xffffU);
          x_[i] >>= 16U;
        }
        x_[i] = ((x_[i] / frequency) << kDepthScaleBits) + x_[i] % frequency + table.start[index];
      }
      return words;
    }

    Words Decode(const SymbolTable& table, const Words& context, const uint16_t** words) {
      return Make([&](size_t i) {
        const uint32_t slot = x_[i] & (kDepthScale - 1);
        size_t index = static_cast<size_t>(context.lanes[i]);
        while (slot - table.start[index] >= table.frequency[index]) index += kDepthContexts;
        x_[i] = table.frequency[index] * (x_[i] >> kDepthScaleBits) + slot - table.start[index];
        if (x_[i] < kDepthStateLow) x_[i] = (x_[i] << 16U) | *(*words)++;
        return static_cast<int>(index / kDepthContexts);
      });
    }

   private:
    uint32_t x_[32];
  };

 private:
  static uint32_t Bit(Mask mask, size_t lane) { return (mask >> lane) & 1U; }

  template <class Function>
  static Words Make(const Function& function) {
    Words a;
    for (size_t i = 0; i < 32; ++i) a.lanes[i] = static_cast<int16_t>(function(i));
    return a;
  }
  template <class Function>
  static Mask Where(const Function& function) {
    Mask mask = 0;
    for (size_t i = 0; i < 32; ++i) mask |= (function(i) ? 1U : 0U) << i;
    return mask;
  }
};

using Kernels = LaneKernels<PortableLanes>;

}  // namespace

const DepthKernels kPortableDepthKernels = {
    "portable", PortableLanes::MarkValues, Kernels::Tokenize, Kernels::Encode, Kernels::Decode};

}  // namespace vantage
