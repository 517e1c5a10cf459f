#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace vantage {

struct DepthFrames {
  std::string name;                           ///< of the set
  int width = 0;                              ///< px
  int height = 0;                             ///< px
  std::vector<std::vector<uint16_t>> frames;  ///< mm, 0: no measurement
};

/// A way to make depth images smaller. State that it may keep between frames, as a camera process
/// would, lives in the functions.
struct DepthCodecRow {
  std::string name;
  std::function<void(const DepthFrames&, std::span<const uint16_t>, std::vector<uint8_t>*)> encode;
  /// Gets `depth` in its right size; false where the bytes are no such image.
  std::function<bool(const DepthFrames&, std::span<const uint8_t>, std::vector<uint16_t>*)> decode;
};

/// Ours first.
std::vector<DepthCodecRow> MakeDepthCodecs();

}  // namespace vantage
