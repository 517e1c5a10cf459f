#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

namespace vantage {

/// The big-endian integer at the start of `bytes`, which has at least sizeof(T) of them.
template <std::integral T>
T LoadBigEndian(std::span<const std::byte> bytes) {
  using Unsigned = std::make_unsigned_t<T>;
  Unsigned value = 0;
  for (size_t i = 0; i < sizeof(T); ++i) {
    value = static_cast<Unsigned>((static_cast<uint64_t>(value) << 8U) |
                                  std::to_integer<uint64_t>(bytes[i]));
  }
  return static_cast<T>(value);
}

/// Writes a big-endian integer to the start of `bytes`, which has room for it.
template <std::integral T>
void StoreBigEndian(T value, std::span<std::byte> bytes) {
  auto rest = static_cast<uint64_t>(static_cast<std::make_unsigned_t<T>>(value));
  for (size_t i = sizeof(T); i-- > 0;) {
    bytes[i] = static_cast<std::byte>(rest & 0xffU);
    rest >>= 8U;
  }
}

}  // namespace vantage
