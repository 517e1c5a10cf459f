#include "common/jpeg_decoder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>

#include "common/rng.h"
#include "tests/common/jpeg_encoder.h"

namespace vantage {
namespace {

constexpr int kWidth = 64;
constexpr int kHeight = 48;

// Smooth, so that little is lost.
std::vector<uint8_t> Picture(int channels) {
  std::vector<uint8_t> pixels;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      for (int c = 0; c < channels; ++c) {
        pixels.push_back(static_cast<uint8_t>(
            std::lround(128.0 + 90.0 * std::sin(0.1 * u + 0.07 * v + 2.0 * c))));
      }
    }
  }
  return pixels;
}

std::vector<uint8_t> MakeJpeg(int channels, bool progressive = false) {
  return EncodeJpeg(Picture(channels), kWidth, kHeight, channels, progressive);
}

// Without the segments of one kind, as cameras leave out the Huffman tables (0xc4).
std::vector<uint8_t> Without(uint8_t marker, const std::vector<uint8_t>& jpeg) {
  std::vector<uint8_t> kept(jpeg.begin(), jpeg.begin() + 2);
  size_t at = 2;
  while (jpeg[at + 1] != 0xda) {
    const size_t end = at + 2 + 256U * jpeg[at + 2] + jpeg[at + 3];
    if (jpeg[at + 1] != marker) kept.insert(kept.end(), &jpeg[at], &jpeg[end]);
    at = end;
  }
  kept.insert(kept.end(), jpeg.begin() + static_cast<std::ptrdiff_t>(at), jpeg.end());
  return kept;
}

int LargestDifference(const std::vector<uint8_t>& a, const std::vector<uint8_t>& b) {
  if (a.size() != b.size()) return 256;
  int largest = 0;
  for (size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

std::string Fault(const std::vector<uint8_t>& jpeg, JpegPixels kind = JpegPixels::kRgb) {
  std::vector<uint8_t> pixels;
  const Result<void> decoded = DecodeJpeg(jpeg, kWidth, kHeight, kind, &pixels);
  return decoded.ok() ? "" : decoded.error().message;
}

TEST(DecodeJpeg, GivesBackColorGrayAndLuma) {
  std::vector<uint8_t> pixels;
  ASSERT_TRUE(DecodeJpeg(MakeJpeg(3), kWidth, kHeight, JpegPixels::kRgb, &pixels).ok());
  EXPECT_LE(LargestDifference(pixels, Picture(3)), 12);
  ASSERT_TRUE(DecodeJpeg(MakeJpeg(1), kWidth, kHeight, JpegPixels::kGray, &pixels).ok());
  EXPECT_LE(LargestDifference(pixels, Picture(1)), 4);

  const std::vector<uint8_t> rgb = Picture(3);
  std::vector<uint8_t> luma;
  for (size_t i = 0; i < rgb.size(); i += 3) {
    const double y = 0.299 * rgb[i] + 0.587 * rgb[i + 1] + 0.114 * rgb[i + 2];
    luma.push_back(static_cast<uint8_t>(std::lround(y)));
  }
  ASSERT_TRUE(DecodeJpeg(MakeJpeg(3), kWidth, kHeight, JpegPixels::kGray, &pixels).ok());
  EXPECT_LE(LargestDifference(pixels, luma), 4);
}

TEST(DecodeJpeg, MotionJpegNeedsNoHuffmanTables) {
  const std::vector<uint8_t> whole = MakeJpeg(3);
  const std::vector<uint8_t> bare = Without(0xc4, whole);
  ASSERT_LT(bare.size() + 400, whole.size());
  std::vector<uint8_t> from_whole;
  std::vector<uint8_t> from_bare;
  ASSERT_TRUE(DecodeJpeg(whole, kWidth, kHeight, JpegPixels::kRgb, &from_whole).ok());
  ASSERT_TRUE(DecodeJpeg(bare, kWidth, kHeight, JpegPixels::kRgb, &from_bare).ok());
  EXPECT_EQ(from_bare, from_whole);
}

TEST(DecodeJpeg, StrayBytesAreNoDamage) {
  std::vector<uint8_t> jpeg = MakeJpeg(3);
  jpeg.insert(jpeg.end() - 2, 5, uint8_t{0x11});  // Before the marker of the end.
  jpeg.insert(jpeg.end(), 4096, uint8_t{0});      // A buffer's rest.
  EXPECT_EQ(Fault(jpeg), "");
}

TEST(DecodeJpeg, SaysWhatIsWrong) {
  const std::vector<uint8_t> jpeg = MakeJpeg(3);
  EXPECT_NE(Fault({}).find(
                "JPEG image of 0 bytes: is too short for its size, expected a whole baseline image "
                "of 64 x 48 px"),
            std::string::npos)
      << Fault({});
  const std::vector<uint8_t> other_file(100, 1);
  EXPECT_NE(Fault(other_file).find("Not a JPEG file"), std::string::npos) << Fault(other_file);
  EXPECT_NE(Fault(MakeJpeg(3, true)).find("has several scans"), std::string::npos);
  std::vector<uint8_t> pixels;
  const auto other = DecodeJpeg(jpeg, 2 * kWidth, kHeight, JpegPixels::kRgb, &pixels);
  ASSERT_FALSE(other.ok());
  EXPECT_NE(other.error().message.find("has another size"), std::string::npos);
}

TEST(DecodeJpeg, EveryTruncationIsAnError) {
  const std::vector<uint8_t> jpeg = MakeJpeg(3);
  for (size_t size = 0; size + 2 < jpeg.size(); ++size) {
    const std::vector<uint8_t> part(jpeg.begin(), jpeg.begin() + static_cast<std::ptrdiff_t>(size));
    ASSERT_NE(Fault(part), "") << size << " of " << jpeg.size();
  }
}

TEST(DecodeJpeg, DamageNeverCrashes) {
  const std::vector<uint8_t> jpeg = MakeJpeg(3);
  Rng rng(7);
  int num_refused = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    std::vector<uint8_t> damaged = jpeg;
    for (int i = 0; i < 1 + trial % 8; ++i) {
      damaged[rng.Below(static_cast<uint32_t>(damaged.size()))] =
          static_cast<uint8_t>(rng.Below(256));
    }
    num_refused +=
        Fault(damaged, trial % 2 == 0 ? JpegPixels::kRgb : JpegPixels::kGray).empty() ? 0 : 1;
  }
  EXPECT_GT(num_refused, 500);
}

}  // namespace
}  // namespace vantage
