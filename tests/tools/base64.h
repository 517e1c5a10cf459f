#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

namespace vantage {

/// The bytes of RFC 4648 text; stops at the first character that is none of its digits. Written
/// bit by bit, to judge the encoder by.
inline std::vector<uint8_t> DecodeBase64(std::string_view text) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::vector<bool> bits;
  for (const char digit : text) {
    const size_t value = kDigits.find(digit);
    if (value == std::string_view::npos) break;
    for (int bit = 5; bit >= 0; --bit) bits.push_back((value >> bit & 1U) != 0U);
  }
  std::vector<uint8_t> bytes(bits.size() / 8);
  for (size_t i = 0; i < 8 * bytes.size(); ++i) {
    bytes[i / 8] = static_cast<uint8_t>(bytes[i / 8] << 1U | (bits[i] ? 1U : 0U));
  }
  return bytes;
}

}  // namespace vantage
