#pragma once

#include <cstddef>
#include <cstdint>

namespace vantage {

/// The layout of a compressed depth image; docs/depth-codec.md tells it byte by byte. All numbers
/// are little-endian.
///   0  4  magic "VDC" and the version
///   4  4  CRC-32C of all bytes from 8 on
///   8  2  width, px
///  10  2  height, px
///  12  1  mode
///  13     what the mode says
inline constexpr uint32_t kDepthMagic = 0x01434456U;
inline constexpr size_t kDepthHeaderBytes = 13;
inline constexpr int kMaxDepthSide = 4096;  ///< px

enum class DepthMode : uint8_t {
  kStored = 0,  ///< width * height pixels of 2 bytes
};

}  // namespace vantage
