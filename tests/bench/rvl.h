#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace vantage {

/// Run length and variable length codes of depth images: Wilson, "Fast Lossless Depth Image
/// Compression", ISS 2017. Words of eight nibbles, the first one in the highest bits.
void EncodeRvl(std::span<const uint16_t> depth, std::vector<uint8_t>* bytes);

/// @param depth of the size that was encoded
/// @return false where the bytes end too early or tell of more pixels.
bool DecodeRvl(std::span<const uint8_t> bytes, std::span<uint16_t> depth);

}  // namespace vantage
