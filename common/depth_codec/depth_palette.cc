#include "common/depth_codec/depth_palette.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <numeric>

namespace vantage {
namespace {

constexpr uint32_t kLargestRiceBits = 15;

class BitWriter {
 public:
  explicit BitWriter(std::vector<uint8_t>* bytes) : bytes_(bytes) {}
  void Put(bool bit) {
    if (free_ == 0) {
      bytes_->push_back(0);
      free_ = 8;
    }
    bytes_->back() = static_cast<uint8_t>(bytes_->back() | ((bit ? 1U : 0U) << (8 - free_)));
    --free_;
  }

 private:
  std::vector<uint8_t>* bytes_;
  int free_ = 0;
};

class BitReader {
 public:
  explicit BitReader(std::span<const uint8_t> bytes) : bytes_(bytes) {}
  /// 1 past the end, which ends no unary number.
  uint32_t Get() {
    const size_t byte = next_ / 8;
    if (byte >= bytes_.size()) return 1;
    return (bytes_[byte] >> (next_++ % 8)) & 1U;
  }
  [[nodiscard]] bool AtEnd() const { return next_ / 8 >= bytes_.size(); }
  [[nodiscard]] size_t bytes() const { return (next_ + 7) / 8; }

 private:
  std::span<const uint8_t> bytes_;
  size_t next_ = 0;
};

void Append16(size_t value, std::vector<uint8_t>* bytes) {
  bytes->push_back(static_cast<uint8_t>(value & 0xffU));
  bytes->push_back(static_cast<uint8_t>(value >> 8U));
}

uint32_t Load16(std::span<const uint8_t> bytes, size_t at) {
  return bytes[at] | (uint32_t{bytes[at + 1]} << 8U);
}

}  // namespace

DepthPalette::DepthPalette()
    : present_(new uint8_t[kValues]()),
      ranks_(new uint16_t[kValues]()),
      values_(new uint16_t[kValues]()) {}

void DepthPalette::Build(std::span<const uint16_t> depth) {
  uint8_t* present = present_.get();
  std::memset(present, 0, kValues);
  for (const uint16_t value : depth) present[value] = 1;
  present[0] = 0;
  size_ = 0;
  for (size_t first = 0; first < kValues; first += 8) {
    uint64_t eight = 0;
    std::memcpy(&eight, present + first, 8);
    if (eight == 0) continue;
    for (size_t value = first; value < first + 8; ++value) {
      if (present[value] == 0) continue;
      values_[++size_] = static_cast<uint16_t>(value);
      ranks_[value] = static_cast<uint16_t>(size_);
    }
  }
}

void DepthPalette::Append(std::vector<uint8_t>* bytes) const {
  Append16(size_, bytes);
  if (size_ == 0) return;
  Append16(values_[1], bytes);
  uint32_t factor = 0;
  for (size_t i = 2; i <= size_; ++i) {
    factor = std::gcd(factor, static_cast<uint32_t>(values_[i] - values_[i - 1]));
  }
  factor = std::max(factor, 1U);
  const auto step = [&](size_t i) {
    return static_cast<uint32_t>(values_[i] - values_[i - 1]) / factor - 1;
  };
  uint32_t best_k = 0;
  size_t best_bits = std::numeric_limits<size_t>::max();
  for (uint32_t k = 0; k <= kLargestRiceBits; ++k) {
    size_t bits = 0;
    for (size_t i = 2; i <= size_; ++i) bits += (step(i) >> k) + 1 + k;
    if (bits < best_bits) {
      best_bits = bits;
      best_k = k;
    }
  }
  Append16(factor, bytes);
  bytes->push_back(static_cast<uint8_t>(best_k));
  BitWriter writer(bytes);
  for (size_t i = 2; i <= size_; ++i) {
    const uint32_t number = step(i);
    for (uint32_t ones = number >> best_k; ones > 0; --ones) writer.Put(true);
    writer.Put(false);
    for (uint32_t bit = 0; bit < best_k; ++bit) writer.Put(((number >> bit) & 1U) != 0);
  }
}

bool DepthPalette::Read(std::span<const uint8_t>* bytes) {
  if (bytes->size() < 2) return false;
  const size_t size = Load16(*bytes, 0);
  if (size == 0) {
    size_ = 0;
    *bytes = bytes->subspan(2);
    return true;
  }
  if (bytes->size() < 7) return false;
  const uint32_t first = Load16(*bytes, 2);
  const uint32_t factor = Load16(*bytes, 4);
  const uint32_t k = (*bytes)[6];
  if (first == 0 || factor == 0 || k > kLargestRiceBits) return false;
  BitReader reader(bytes->subspan(7));
  uint32_t value = first;
  values_[1] = static_cast<uint16_t>(value);
  for (size_t i = 2; i <= size; ++i) {
    uint32_t number = 0;
    while (reader.Get() == 1) {
      number += 1U << k;
      if (number >= kValues || reader.AtEnd()) return false;
    }
    for (uint32_t bit = 0; bit < k; ++bit) {
      if (reader.AtEnd()) return false;
      number += reader.Get() << bit;
    }
    const uint64_t next = value + uint64_t{factor} * (uint64_t{number} + 1);
    if (next >= kValues) return false;
    value = static_cast<uint32_t>(next);
    values_[i] = static_cast<uint16_t>(value);
  }
  size_ = size;
  *bytes = bytes->subspan(7 + reader.bytes());
  return true;
}

}  // namespace vantage
