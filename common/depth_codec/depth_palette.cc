#include "common/depth_codec/depth_palette.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <numeric>

namespace vantage {
namespace {

constexpr uint32_t kLargestRiceBits = 15;

// Bits fill bytes from the lowest one on.
class BitWriter {
 public:
  explicit BitWriter(std::vector<uint8_t>* bytes) : bytes_(bytes) {}
  void Put(uint32_t bits, uint32_t count) {
    waiting_ |= bits << num_waiting_;
    for (num_waiting_ += count; num_waiting_ >= 8; num_waiting_ -= 8, waiting_ >>= 8U) {
      bytes_->push_back(static_cast<uint8_t>(waiting_ & 0xffU));
    }
  }
  void Finish() {
    if (num_waiting_ > 0) bytes_->push_back(static_cast<uint8_t>(waiting_));
  }

 private:
  std::vector<uint8_t>* bytes_;
  uint32_t waiting_ = 0;
  uint32_t num_waiting_ = 0;  // Below 8 between calls.
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
    : present_(new uint8_t[kValues]),
      ranks_(new uint16_t[kValues]()),
      values_(new uint16_t[kValues]()) {}

void DepthPalette::Build(std::span<const uint16_t> depth,
                         size_t width,
                         const DepthKernels& kernels) {
  uint8_t* present = present_.get();
  std::memset(present, 0, kValues);
  kernels.mark_values(depth.data(), depth.size(), width, present);
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
    const auto difference = static_cast<uint32_t>(values_[i] - values_[i - 1]);
    if (factor == 0 || difference % factor != 0) factor = std::gcd(factor, difference);
    if (factor == 1) break;
  }
  factor = std::max(factor, 1U);
  const auto step = [&](size_t i) {
    return static_cast<uint32_t>(values_[i] - values_[i - 1]) / factor - 1;
  };
  // Near the best k: 2^k about the mean.
  const size_t span = static_cast<size_t>(values_[size_] - values_[1]) / factor;
  const size_t mean = size_ > 1 ? span / (size_ - 1) - 1 : 0;
  const auto k = static_cast<uint32_t>(mean == 0 ? 0 : std::bit_width(mean) - 1);
  Append16(factor, bytes);
  bytes->push_back(static_cast<uint8_t>(k));
  BitWriter writer(bytes);
  for (size_t i = 2; i <= size_; ++i) {
    const uint32_t number = step(i);
    for (uint32_t ones = number >> k; ones > 0; --ones) writer.Put(1, 1);
    writer.Put((number & ((1U << k) - 1U)) << 1U, k + 1);
  }
  writer.Finish();
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
