#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace vantage {

/// CRC-32C (Castagnoli), as in RFC 3720, section 12.1: reflected, polynomial 0x1EDC6F41, begun with
/// and inverted by 0xFFFFFFFF. By the processor's instruction where it has one (SSE 4.2).
uint32_t Crc32c(std::span<const uint8_t> bytes);

/// The same by a table alone.
uint32_t Crc32cByTable(std::span<const uint8_t> bytes);

}  // namespace vantage
