#include "drivers/v4l2/pixel_conversion.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

namespace vantage {
namespace {

// Fixed point, so that GCC makes vector code of the loops.
constexpr int kBits = 16;
constexpr int32_t kHalf = 1 << (kBits - 1);

int32_t Fixed(double value) { return static_cast<int32_t>(std::lround(value * (1 << kBits))); }

// R' = y (Y' - black) + r_cr (Cr - 128) and so on, as the standards' equations solved for R'G'B'.
struct YuvMatrix {
  int32_t black;
  int32_t y;
  int32_t r_cr;
  int32_t g_cb;
  int32_t g_cr;
  int32_t b_cb;
};

YuvMatrix MatrixOf(const YuvEncoding& encoding) {
  const double kr = encoding.bt709 ? 0.2126 : 0.299;
  const double kb = encoding.bt709 ? 0.0722 : 0.114;
  const double kg = 1.0 - kr - kb;
  const double chroma = encoding.full_range ? 1.0 : 255.0 / 224.0;
  return {encoding.full_range ? 0 : 16,
          Fixed(encoding.full_range ? 1.0 : 255.0 / 219.0),
          Fixed(2.0 * (1.0 - kr) * chroma),
          Fixed(-2.0 * (1.0 - kb) * kb / kg * chroma),
          Fixed(-2.0 * (1.0 - kr) * kr / kg * chroma),
          Fixed(2.0 * (1.0 - kb) * chroma)};
}

const uint8_t* Row(const PixelRows& rows, int v) {
  return reinterpret_cast<const uint8_t*>(rows.data) + v * rows.stride_bytes;
}

uint8_t ToByte(int32_t fixed) {
  return static_cast<uint8_t>(std::clamp((fixed + kHalf) >> kBits, 0, 255));
}

struct YuvPlaces {
  int y;
  int cb;
  int cr;
};

constexpr YuvPlaces PlacesOf(YuvOrder order) {
  return order == YuvOrder::kYuyv ? YuvPlaces{0, 1, 3} : YuvPlaces{1, 0, 2};
}

void StorePixel(int32_t y, int32_t red, int32_t green, int32_t blue, uint8_t* pixel) {
  pixel[0] = ToByte(y + red);
  pixel[1] = ToByte(y + green);
  pixel[2] = ToByte(y + blue);
}

template <YuvOrder order>
void YuvRowToRgb(const uint8_t* row, int width, const YuvMatrix& matrix, uint8_t* rgb) {
  constexpr YuvPlaces kPlaces = PlacesOf(order);
  const YuvMatrix m = matrix;  // Of which the compiler knows that no pixel is part of it.
  for (int u = 0; u < width; u += 2, row += 4, rgb += 6) {
    const int32_t cb = row[kPlaces.cb] - 128;
    const int32_t cr = row[kPlaces.cr] - 128;
    const int32_t red = m.r_cr * cr;
    const int32_t green = m.g_cb * cb + m.g_cr * cr;
    const int32_t blue = m.b_cb * cb;
    StorePixel(m.y * (row[kPlaces.y] - m.black), red, green, blue, rgb);
    if (u + 1 == width) return;
    StorePixel(m.y * (row[kPlaces.y + 2] - m.black), red, green, blue, rgb + 3);
  }
}

// One more pixel on either side, mirrored so that the pattern of colors goes on.
void PadRow(const uint8_t* row, int width, uint8_t* padded) {
  std::copy_n(row, width, padded + 1);
  padded[0] = row[1];
  padded[width + 1] = row[width - 2];
}

uint8_t Mean2(int a, int b) { return static_cast<uint8_t>((a + b + 1) / 2); }
uint8_t Mean4(int a, int b, int c, int d) { return static_cast<uint8_t>((a + b + c + d + 2) / 4); }

// The rows point at the first true pixel. `own` is the place in a pixel of the color that this row
// has beside green: 0 or 2; it is in the columns of parity `own_parity`.
void BayerRowToRgb(const uint8_t* above,
                   const uint8_t* row,
                   const uint8_t* below,
                   int width,
                   int own,
                   int own_parity,
                   uint8_t* rgb) {
  const int other = 2 - own;
  for (int u = 0; u < width; ++u) {
    uint8_t* pixel = rgb + 3 * u;
    if (u % 2 == own_parity) {
      pixel[own] = row[u];
      pixel[1] = Mean4(row[u - 1], row[u + 1], above[u], below[u]);
      pixel[other] = Mean4(above[u - 1], above[u + 1], below[u - 1], below[u + 1]);
    } else {
      pixel[own] = Mean2(row[u - 1], row[u + 1]);
      pixel[1] = row[u];
      pixel[other] = Mean2(above[u], below[u]);
    }
  }
}

}  // namespace

void YuvToRgb(const PixelRows& yuv, YuvOrder order, const YuvEncoding& encoding, uint8_t* rgb) {
  const YuvMatrix matrix = MatrixOf(encoding);
  for (int v = 0; v < yuv.height; ++v, rgb += 3 * static_cast<int64_t>(yuv.width)) {
    if (order == YuvOrder::kYuyv) {
      YuvRowToRgb<YuvOrder::kYuyv>(Row(yuv, v), yuv.width, matrix, rgb);
    } else {
      YuvRowToRgb<YuvOrder::kUyvy>(Row(yuv, v), yuv.width, matrix, rgb);
    }
  }
}

void YuvToGray(const PixelRows& yuv, YuvOrder order, const YuvEncoding& encoding, uint8_t* gray) {
  const YuvMatrix matrix = MatrixOf(encoding);
  std::array<uint8_t, 256> full;
  for (int y = 0; y < 256; ++y) {
    full[static_cast<size_t>(y)] = ToByte(matrix.y * (y - matrix.black));
  }
  const int place = PlacesOf(order).y;
  for (int v = 0; v < yuv.height; ++v, gray += yuv.width) {
    const uint8_t* row = Row(yuv, v) + place;
    for (int u = 0; u < yuv.width; ++u) gray[u] = full[row[2 * u]];
  }
}

void BayerGrbgToRgb(const PixelRows& bayer, uint8_t* rgb) {
  const size_t padded = static_cast<size_t>(bayer.width) + 2;
  std::vector<uint8_t> rows(3 * padded);
  const auto place = [&](int v) { return &rows[padded * static_cast<size_t>((v + 3) % 3)]; };
  PadRow(Row(bayer, 1), bayer.width, place(-1));
  PadRow(Row(bayer, 0), bayer.width, place(0));
  for (int v = 0; v < bayer.height; ++v, rgb += 3 * static_cast<int64_t>(bayer.width)) {
    const int next = v + 1 < bayer.height ? v + 1 : v - 1;
    PadRow(Row(bayer, next), bayer.width, place(v + 1));
    const bool red_row = v % 2 == 0;
    BayerRowToRgb(place(v - 1) + 1,
                  place(v) + 1,
                  place(v + 1) + 1,
                  bayer.width,
                  red_row ? 0 : 2,
                  red_row ? 1 : 0,
                  rgb);
  }
}

void GrayToRgb(const PixelRows& gray, uint8_t* rgb) {
  for (int v = 0; v < gray.height; ++v) {
    const uint8_t* row = Row(gray, v);
    for (int u = 0; u < gray.width; ++u, rgb += 3) rgb[0] = rgb[1] = rgb[2] = row[u];
  }
}

void BgrToRgb(const PixelRows& bgr, uint8_t* rgb) {
  for (int v = 0; v < bgr.height; ++v) {
    const uint8_t* row = Row(bgr, v);
    for (int u = 0; u < bgr.width; ++u, rgb += 3) {
      rgb[0] = row[3 * u + 2];
      rgb[1] = row[3 * u + 1];
      rgb[2] = row[3 * u];
    }
  }
}

void RgbToGray(const PixelRows& rgb, uint8_t* gray) {
  constexpr int32_t kRed = 19595;    // 0.299 * 2^16
  constexpr int32_t kGreen = 38470;  // 0.587 * 2^16
  constexpr int32_t kBlue = 7471;    // 0.114 * 2^16
  for (int v = 0; v < rgb.height; ++v, gray += rgb.width) {
    const uint8_t* row = Row(rgb, v);
    for (int u = 0; u < rgb.width; ++u) {
      const uint8_t* pixel = row + 3 * u;
      gray[u] = ToByte(kRed * pixel[0] + kGreen * pixel[1] + kBlue * pixel[2]);
    }
  }
}

void PackRows(const PixelRows& rows, int64_t row_bytes, uint8_t* packed) {
  for (int v = 0; v < rows.height; ++v, packed += row_bytes) {
    std::memcpy(packed, Row(rows, v), static_cast<size_t>(row_bytes));
  }
}

void UnpackTenBits(const PixelRows& packed,
                   const std::array<uint16_t, 1024>& table,
                   uint16_t* values) {
  for (int v = 0; v < packed.height; ++v, values += packed.width) {
    const uint8_t* five = Row(packed, v);
    int u = 0;
    for (; u + 4 <= packed.width; u += 4, five += 5) {
      const unsigned int a = five[0], b = five[1], c = five[2], d = five[3], e = five[4];
      values[u] = table[a << 2 | b >> 6];
      values[u + 1] = table[(b & 0x3f) << 4 | c >> 4];
      values[u + 2] = table[(c & 0x0f) << 6 | d >> 2];
      values[u + 3] = table[(d & 0x03) << 8 | e];
    }
    // One to three pixels, in as many bytes more.
    for (int i = 0; u < packed.width; ++u, ++i) {
      const unsigned int two = static_cast<unsigned int>(five[i] << 8 | five[i + 1]);
      values[u] = table[(two >> (6 - 2 * i)) & 0x3ff];
    }
  }
}

}  // namespace vantage
