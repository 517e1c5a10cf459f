#include "drivers/v4l2/pixel_conversion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/rng.h"

namespace vantage {
namespace {

using Bytes = std::vector<uint8_t>;

Bytes RandomBytes(size_t size, uint64_t seed) {
  Rng rng(seed);
  Bytes bytes(size);
  for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(rng.Below(256));
  return bytes;
}

PixelRows Rows(const Bytes& bytes, int width, int height, int64_t stride) {
  return {reinterpret_cast<const std::byte*>(bytes.data()), width, height, stride};
}

// The equations of ITU-R BT.601 and BT.709 themselves, in the direction in which they are given:
// R'G'B' of 0 to 1 to Y'CbCr in bytes, not rounded.
struct Yuv {
  double y;
  double cb;
  double cr;
};
Yuv Encode(double r, double g, double b, const YuvEncoding& encoding) {
  const double kr = encoding.bt709 ? 0.2126 : 0.299;
  const double kb = encoding.bt709 ? 0.0722 : 0.114;
  const double y = kr * r + (1.0 - kr - kb) * g + kb * b;
  const double cb = 0.5 * (b - y) / (1.0 - kb);
  const double cr = 0.5 * (r - y) / (1.0 - kr);
  if (encoding.full_range) return {255.0 * y, 128.0 + 255.0 * cb, 128.0 + 255.0 * cr};
  return {16.0 + 219.0 * y, 128.0 + 224.0 * cb, 128.0 + 224.0 * cr};
}

uint8_t Rounded(double value) {
  return static_cast<uint8_t>(std::clamp(std::lround(value), 0L, 255L));
}

const std::vector<YuvEncoding> kEncodings = {
    {false, false}, {false, true}, {true, false}, {true, true}};

TEST(YuvToRgb, UndoesTheStandardsEquations) {
  for (const YuvEncoding& encoding : kEncodings) {
    Rng rng(1);
    for (int i = 0; i < 2000; ++i) {
      const double r = rng.Uniform();
      const double g = rng.Uniform();
      const double b = rng.Uniform();
      const Yuv yuv = Encode(r, g, b, encoding);
      const Bytes pair = {Rounded(yuv.y), Rounded(yuv.cb), Rounded(yuv.y), Rounded(yuv.cr)};
      Bytes rgb(6, 99);
      YuvToRgb(Rows(pair, 2, 1, 4), YuvOrder::kYuyv, encoding, rgb.data());
      // Of the rounding to bytes: half a step of Y', and of Cb or Cr times at most 2.1.
      for (size_t pixel = 0; pixel < 6; pixel += 3) {
        EXPECT_NEAR(rgb[pixel], 255.0 * r, 2.3);
        EXPECT_NEAR(rgb[pixel + 1], 255.0 * g, 2.3);
        EXPECT_NEAR(rgb[pixel + 2], 255.0 * b, 2.3);
      }
    }
  }
}

TEST(YuvToRgb, OfBlackWhiteAndBeyond) {
  const auto convert = [](uint8_t y, uint8_t cb, uint8_t cr, const YuvEncoding& encoding) {
    Bytes rgb(6);
    YuvToRgb(Rows({y, cb, y, cr}, 2, 1, 4), YuvOrder::kYuyv, encoding, rgb.data());
    return Bytes(rgb.begin(), rgb.begin() + 3);
  };
  const YuvEncoding limited;
  const YuvEncoding full{false, true};
  EXPECT_EQ(convert(16, 128, 128, limited), (Bytes{0, 0, 0}));
  EXPECT_EQ(convert(235, 128, 128, limited), (Bytes{255, 255, 255}));
  EXPECT_EQ(convert(0, 128, 128, limited), (Bytes{0, 0, 0}));
  EXPECT_EQ(convert(255, 128, 128, limited), (Bytes{255, 255, 255}));
  EXPECT_EQ(convert(16, 128, 128, full), (Bytes{16, 16, 16}));
  EXPECT_EQ(convert(255, 255, 255, limited)[0], 255);
  EXPECT_EQ(convert(0, 0, 0, limited)[0], 0);
}

TEST(YuvToRgb, OrdersAreTheSamePixels) {
  constexpr int kWidth = 34;
  constexpr int kHeight = 5;
  const Bytes yuyv = RandomBytes(2 * kWidth * kHeight, 2);
  Bytes uyvy = yuyv;
  for (size_t i = 0; i < uyvy.size(); i += 2) std::swap(uyvy[i], uyvy[i + 1]);
  Bytes a(3 * kWidth * kHeight);
  Bytes b(a.size());
  YuvToRgb(Rows(yuyv, kWidth, kHeight, 2 * kWidth), YuvOrder::kYuyv, {}, a.data());
  YuvToRgb(Rows(uyvy, kWidth, kHeight, 2 * kWidth), YuvOrder::kUyvy, {}, b.data());
  EXPECT_EQ(a, b);
  Bytes gray_a(kWidth * kHeight);
  Bytes gray_b(gray_a.size());
  YuvToGray(Rows(yuyv, kWidth, kHeight, 2 * kWidth), YuvOrder::kYuyv, {}, gray_a.data());
  YuvToGray(Rows(uyvy, kWidth, kHeight, 2 * kWidth), YuvOrder::kUyvy, {}, gray_b.data());
  EXPECT_EQ(gray_a, gray_b);
}

TEST(YuvToRgb, LongerRowsAndOddWidthsGiveTheSamePixels) {
  constexpr int kWidth = 7;
  constexpr int kHeight = 3;
  constexpr int kStride = 24;
  const Bytes padded = RandomBytes(kStride * kHeight, 3);
  Bytes all(3 * 8 * kHeight);
  YuvToRgb(Rows(padded, 8, kHeight, kStride), YuvOrder::kYuyv, {}, all.data());
  Bytes odd(3 * kWidth * kHeight + 1, 77);
  YuvToRgb(Rows(padded, kWidth, kHeight, kStride), YuvOrder::kYuyv, {}, odd.data());
  for (int v = 0; v < kHeight; ++v) {
    EXPECT_TRUE(std::equal(
        &odd[size_t{3} * kWidth * v], &odd[size_t{3} * kWidth * (v + 1)], &all[size_t{3} * 8 * v]));
  }
  EXPECT_EQ(odd.back(), 77);
}

TEST(YuvToGray, IsTheLumaInFullRange) {
  const YuvEncoding limited;
  const YuvEncoding full{false, true};
  for (int y = 0; y < 256; ++y) {
    const Bytes pair = {static_cast<uint8_t>(y), 7, static_cast<uint8_t>(y), 250};
    Bytes gray(2);
    YuvToGray(Rows(pair, 2, 1, 4), YuvOrder::kYuyv, limited, gray.data());
    EXPECT_EQ(gray[0], Rounded((y - 16) * 255.0 / 219.0));
    EXPECT_EQ(gray[1], gray[0]);
    YuvToGray(Rows(pair, 2, 1, 4), YuvOrder::kYuyv, full, gray.data());
    EXPECT_EQ(gray[0], y);
  }
}

// The mosaic's color at a place: 0 red, 1 green, 2 blue.
int GrbgColor(int u, int v) {
  if (v % 2 == 0) return u % 2 == 0 ? 1 : 0;
  return u % 2 == 0 ? 2 : 1;
}

// Straight from the definition: the mean of the neighbors, out of the 3 x 3 around a pixel, that
// have the color; beyond the border the image is mirrored.
int DemosaicedByDefinition(const Bytes& mosaic, int width, int height, int u, int v, int color) {
  const auto mirror = [](int at, int size) {
    if (at < 0) return -at;
    return at < size ? at : 2 * size - 2 - at;
  };
  const auto value = [&](int x, int y) {
    return int{mosaic[static_cast<size_t>(mirror(y, height)) * static_cast<size_t>(width) +
                      static_cast<size_t>(mirror(x, width))]};
  };
  if (GrbgColor(u, v) == color) return value(u, v);
  int sum = 0;
  int count = 0;
  for (int y = v - 1; y <= v + 1; ++y) {
    for (int x = u - 1; x <= u + 1; ++x) {
      if (GrbgColor(x & 1, y & 1) != color) continue;
      sum += value(x, y);
      ++count;
    }
  }
  return (sum + count / 2) / count;
}

TEST(BayerGrbgToRgb, IsTheMeanOfTheNeighborsThatHaveTheColor) {
  for (const auto& [width, height] :
       std::vector<std::pair<int, int>>{{2, 2}, {2, 5}, {3, 3}, {7, 2}, {8, 6}, {9, 7}}) {
    const int stride = width + 3;
    const Bytes padded = RandomBytes(static_cast<size_t>(stride * height), 4);
    Bytes mosaic;
    for (int v = 0; v < height; ++v) {
      const auto row = padded.begin() + v * stride;
      mosaic.insert(mosaic.end(), row, row + width);
    }
    Bytes rgb(static_cast<size_t>(3 * width * height));
    BayerGrbgToRgb(Rows(padded, width, height, stride), rgb.data());
    for (int v = 0; v < height; ++v) {
      for (int u = 0; u < width; ++u) {
        for (int color = 0; color < 3; ++color) {
          ASSERT_EQ(rgb[static_cast<size_t>(3 * (v * width + u) + color)],
                    DemosaicedByDefinition(mosaic, width, height, u, v, color))
              << width << " x " << height << ", " << u << " " << v << " " << color;
        }
      }
    }
  }
}

TEST(BayerGrbgToRgb, OfOneColorIsThatColor) {
  constexpr int kWidth = 10;
  constexpr int kHeight = 6;
  const Bytes color = {200, 100, 50};
  Bytes mosaic;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) mosaic.push_back(color[static_cast<size_t>(GrbgColor(u, v))]);
  }
  Bytes rgb(3 * kWidth * kHeight);
  BayerGrbgToRgb(Rows(mosaic, kWidth, kHeight, kWidth), rgb.data());
  for (size_t i = 0; i < rgb.size(); ++i) ASSERT_EQ(rgb[i], color[i % 3]);
}

TEST(RgbToGray, IsTheLumaOfBt601) {
  const Bytes rgb = RandomBytes(size_t{3} * 1000, 5);
  Bytes gray(1000);
  RgbToGray(Rows(rgb, 1000, 1, 3000), gray.data());
  for (size_t i = 0; i < gray.size(); ++i) {
    EXPECT_NEAR(
        gray[i], 0.299 * rgb[3 * i] + 0.587 * rgb[3 * i + 1] + 0.114 * rgb[3 * i + 2], 0.51);
  }
}

TEST(BgrToRgb, SwapsAndLeavesPaddingOut) {
  Bytes rgb(6);
  BgrToRgb(Rows({1, 2, 3, 99, 4, 5, 6, 99}, 1, 2, 4), rgb.data());
  EXPECT_EQ(rgb, (Bytes{3, 2, 1, 6, 5, 4}));
}

TEST(GrayToRgb, RepeatsAndLeavesPaddingOut) {
  Bytes rgb(6);
  GrayToRgb(Rows({1, 99, 4}, 1, 2, 2), rgb.data());
  EXPECT_EQ(rgb, (Bytes{1, 1, 1, 4, 4, 4}));
}

// One bit after the other.
Bytes PackTenBits(const std::vector<uint16_t>& values) {
  Bytes bytes((10 * values.size() + 7) / 8);
  size_t at = 0;
  for (const uint16_t value : values) {
    for (int bit = 9; bit >= 0; --bit, ++at) {
      const int mask = (value >> bit & 1) << (7 - at % 8);
      bytes[at / 8] = static_cast<uint8_t>(bytes[at / 8] | mask);
    }
  }
  return bytes;
}

TEST(UnpackTenBits, UndoesPackingBitByBit) {
  std::array<uint16_t, 1024> table;
  for (size_t i = 0; i < table.size(); ++i) table[i] = static_cast<uint16_t>(60000 - 7 * i);
  Rng rng(6);
  for (int width = 1; width <= 13; ++width) {
    constexpr int kHeight = 3;
    constexpr int kStride = 20;
    std::vector<uint16_t> expected;
    Bytes packed(kStride * kHeight, 0xee);
    for (int v = 0; v < kHeight; ++v) {
      std::vector<uint16_t> row;
      for (int u = 0; u < width; ++u) row.push_back(static_cast<uint16_t>(rng.Below(1024)));
      const Bytes bytes = PackTenBits(row);
      std::ranges::copy(bytes, packed.begin() + kStride * v);
      for (const uint16_t value : row) expected.push_back(table[value]);
    }
    std::vector<uint16_t> values(expected.size());
    UnpackTenBits(Rows(packed, width, kHeight, kStride), table, values.data());
    EXPECT_EQ(values, expected) << width;
  }
}

TEST(PackRows, LeavesPaddingOut) {
  Bytes packed(6);
  PackRows(Rows({1, 2, 3, 99, 4, 5, 6}, 3, 2, 4), 3, packed.data());
  EXPECT_EQ(packed, (Bytes{1, 2, 3, 4, 5, 6}));
}

}  // namespace
}  // namespace vantage
