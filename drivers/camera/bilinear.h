#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace vantage {

/// Interpolation between four pixels: that at `top`, its right neighbor, and those `row` bytes
/// below. The shares of what is right and below are in 1/256, at most 256. What has no share is
/// read all the same, up to eight bytes from `top` and from `top + row`.
namespace bilinear {

inline constexpr unsigned kWhole = 256;

inline uint8_t Gray(const uint8_t* top, size_t row, unsigned right, unsigned down) {
  const uint8_t* bottom = top + row;
  const unsigned left = kWhole - right;
  const unsigned above = top[0] * left + top[1] * right;
  const unsigned below = bottom[0] * left + bottom[1] * right;
  const unsigned mixed = above * (kWhole - down) + below * down + kWhole * kWhole / 2;
  return static_cast<uint8_t>(mixed / (kWhole * kWhole));
}

using Bytes = uint8_t __attribute__((vector_size(16)));
using Words = uint16_t __attribute__((vector_size(16)));

// Eight bytes, as numbers.
[[gnu::always_inline]] inline void Load(const uint8_t* from, Words* numbers) {
  Bytes bytes = {};
  std::memcpy(&bytes, from, 8);
  bytes = __builtin_shufflevector(
      bytes, Bytes{}, 0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
  std::memcpy(numbers, &bytes, sizeof(Words));
}

/// Three channels at once: eight bytes reach from a pixel to its right neighbor.
[[gnu::always_inline]] inline void Rgb(
    const uint8_t* top, size_t row, unsigned right, unsigned down, uint8_t* mixed) {
  const auto right_share = static_cast<uint16_t>(right);
  const auto left_share = static_cast<uint16_t>(kWhole - right);
  const auto bottom_share = static_cast<uint16_t>(down);
  const auto top_share = static_cast<uint16_t>(kWhole - down);
  Words above;
  Words below;
  Load(top, &above);
  Load(top + row, &below);
  // At most 255 * 256 + 128, which 16 bits hold.
  const Words column = (above * top_share + below * bottom_share + 128) >> 8;
  const Words next = __builtin_shufflevector(column, column, 3, 4, 5, 3, 3, 4, 5, 3);
  const Words both = (column * left_share + next * right_share + 128) >> 8;
  Bytes bytes;
  std::memcpy(&bytes, &both, sizeof(Bytes));
  bytes =
      __builtin_shufflevector(bytes, bytes, 0, 2, 4, 6, 8, 10, 12, 14, 0, 2, 4, 6, 8, 10, 12, 14);
  uint32_t pixel = 0;
  std::memcpy(&pixel, &bytes, sizeof(pixel));
  std::memcpy(mixed, &pixel, 3);
}

}  // namespace bilinear
}  // namespace vantage
