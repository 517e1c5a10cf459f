#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/result.h"

namespace vantage {

/// Reads what DepthEncoder writes. Keeps buffers between images; use one decoder a thread.
class DepthDecoder {
 public:
  /// @param payload from outside; may hold anything
  /// @param width, height px, what the image must be; 1..kMaxDepthSide
  /// @param depth width * height values; after an error its content is unspecified
  /// Errors: no such payload, or of another version or size, or damaged. Memory is taken for no
  /// more than width * height pixels, whatever the payload claims.
  Result<void> Decode(std::span<const uint8_t> payload,
                      int width,
                      int height,
                      std::vector<uint16_t>* depth);
};

}  // namespace vantage
