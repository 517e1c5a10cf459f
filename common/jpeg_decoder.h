#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/result.h"

namespace vantage {

/// What a JPEG image is decoded to.
enum class JpegPixels {
  kGray,  ///< one byte a pixel, luma of ITU-R BT.601
  kRgb,   ///< three bytes a pixel
};

/// Decodes a JPEG image of a known size, as cameras make them: baseline, one scan, gray or YCbCr,
/// the standard Huffman tables where it has none (motion JPEG). Bytes between its markers and after
/// its end, of which many cameras leave some, are passed over.
/// @param width, height px, at least 1; as much is allocated, and no more than 768 times the image.
/// @param pixels becomes width * height pixels, rows one after the other.
/// Errors: no JPEG image, one of another size or kind, a damaged or truncated one.
Result<void> DecodeJpeg(std::span<const uint8_t> jpeg,
                        int width,
                        int height,
                        JpegPixels kind,
                        std::vector<uint8_t>* pixels);

}  // namespace vantage
