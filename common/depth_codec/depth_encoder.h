#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace vantage {

/// Compresses 16-bit depth images without loss. Each image stands for itself: what was lost on the
/// way harms no other. The format is in docs/depth-codec.md.
/// Keeps buffers between images; use one encoder a thread.
class DepthEncoder {
 public:
  /// @param width, height px, 1..kMaxDepthSide
  /// @param depth width * height values in any unit, 0 where there is no measurement
  std::vector<uint8_t> Encode(int width, int height, std::span<const uint16_t> depth);

  /// The same into a buffer that is used again: nothing is allocated once it is large enough.
  void Encode(int width,
              int height,
              std::span<const uint16_t> depth,
              std::vector<uint8_t>* payload);
};

}  // namespace vantage
