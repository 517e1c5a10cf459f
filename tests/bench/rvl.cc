#include "tests/bench/rvl.h"

#include <algorithm>
#include <cstring>

namespace vantage {
namespace {

// Three bits a nibble, the lowest first; the fourth says that more come.
class NibbleWriter {
 public:
  explicit NibbleWriter(uint8_t* out) : out_(out) {}

  void Put(uint32_t value) {
    do {
      const uint32_t more = value > 7 ? 8U : 0U;
      word_ = (word_ << 4U) | (value & 7U) | more;
      value >>= 3U;
      if (++count_ == 8) Flush();
    } while (value != 0);
  }
  uint8_t* Finish() {
    if (count_ > 0) {
      word_ <<= 4U * (8U - count_);
      Flush();
    }
    return out_;
  }

 private:
  void Flush() {
    std::memcpy(out_, &word_, 4);
    out_ += 4;
    word_ = 0;
    count_ = 0;
  }

  uint8_t* out_;
  uint32_t word_ = 0;
  uint32_t count_ = 0;
};

class NibbleReader {
 public:
  explicit NibbleReader(std::span<const uint8_t> bytes)
      : in_(bytes.data()), end_(bytes.data() + bytes.size() / 4 * 4) {}

  bool Get(uint32_t* value) {
    *value = 0;
    for (uint32_t shift = 0; shift < 30; shift += 3) {
      if (count_ == 0 && !Fill()) return false;
      const uint32_t nibble = word_ >> 28U;
      word_ <<= 4U;
      --count_;
      *value |= (nibble & 7U) << shift;
      if ((nibble & 8U) == 0) return true;
    }
    return false;
  }

 private:
  bool Fill() {
    if (in_ == end_) return false;
    std::memcpy(&word_, in_, 4);
    in_ += 4;
    count_ = 8;
    return true;
  }

  const uint8_t* in_;
  const uint8_t* end_;
  uint32_t word_ = 0;
  uint32_t count_ = 0;
};

}  // namespace

void EncodeRvl(std::span<const uint16_t> depth, std::vector<uint8_t>* bytes) {
  // A difference takes six nibbles at most, and each pair of runs two small ones more.
  bytes->resize(4 * depth.size() + 64);
  NibbleWriter writer(bytes->data());
  int previous = 0;
  for (size_t i = 0; i < depth.size();) {
    const size_t zeros = i;
    while (i < depth.size() && depth[i] == 0) ++i;
    writer.Put(static_cast<uint32_t>(i - zeros));
    size_t end = i;
    while (end < depth.size() && depth[end] != 0) ++end;
    writer.Put(static_cast<uint32_t>(end - i));
    for (; i < end; ++i) {
      const int delta = depth[i] - previous;
      writer.Put(static_cast<uint32_t>((delta << 1) ^ (delta >> 31)));
      previous = depth[i];
    }
  }
  bytes->resize(static_cast<size_t>(writer.Finish() - bytes->data()));
}

bool DecodeRvl(std::span<const uint8_t> bytes, std::span<uint16_t> depth) {
  NibbleReader reader(bytes);
  int previous = 0;
  for (size_t i = 0; i < depth.size();) {
    uint32_t zeros = 0;
    uint32_t values = 0;
    if (!reader.Get(&zeros) || zeros > depth.size() - i) return false;
    std::fill_n(depth.begin() + static_cast<std::ptrdiff_t>(i), zeros, uint16_t{0});
    i += zeros;
    if (!reader.Get(&values) || values > depth.size() - i) return false;
    for (const size_t end = i + values; i < end; ++i) {
      uint32_t folded = 0;
      if (!reader.Get(&folded)) return false;
      previous += static_cast<int>(folded >> 1U) ^ -static_cast<int>(folded & 1U);
      depth[i] = static_cast<uint16_t>(previous);
    }
  }
  return true;
}

}  // namespace vantage
