#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace vantage {

/// An image as it lies in a buffer.
struct PixelRows {
  const std::byte* data = nullptr;
  int width = 0;             ///< px
  int height = 0;            ///< px
  int64_t stride_bytes = 0;  ///< from one row to the next
};

/// How Y'CbCr was made of R'G'B'.
struct YuvEncoding {
  bool bt709 = false;       ///< ITU-R BT.709; else BT.601, which USB cameras use
  bool full_range = false;  ///< 0 to 255; else Y' of 16 to 235, Cb and Cr of 16 to 240

  bool operator==(const YuvEncoding&) const = default;
};

/// Where the bytes of two pixels of 4:2:2 are.
enum class YuvOrder { kYuyv, kUyvy };

/// To three bytes a pixel, R first. Out of range after the matrix is clamped. A last odd column has
/// its own Cb and Cr from one sample of each, as if its pair were there; rows hold whole pairs.
void YuvToRgb(const PixelRows& yuv, YuvOrder order, const YuvEncoding& encoding, uint8_t* rgb);
/// The luma alone, in full range.
void YuvToGray(const PixelRows& yuv, YuvOrder order, const YuvEncoding& encoding, uint8_t* gray);

/// Rows G R G R, B G B G: what a pixel lacks is the mean of its nearest neighbors that have it.
/// At least 2 x 2 px.
void BayerGrbgToRgb(const PixelRows& bayer, uint8_t* rgb);

void GrayToRgb(const PixelRows& gray, uint8_t* rgb);
/// Blue first in memory.
void BgrToRgb(const PixelRows& bgr, uint8_t* rgb);
/// BT.601's luma.
void RgbToGray(const PixelRows& rgb, uint8_t* gray);
/// Rows of so many bytes without gaps.
void PackRows(const PixelRows& rows, int64_t row_bytes, uint8_t* packed);

/// Ten bits a pixel without gaps in a row, the highest bit first: table[value] of each.
void UnpackTenBits(const PixelRows& packed,
                   const std::array<uint16_t, 1024>& table,
                   uint16_t* values);

}  // namespace vantage
