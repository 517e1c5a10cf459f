// The parts of the depth codec: checksum, palette, window, frequencies.
#include <gtest/gtest.h>

#include <numeric>
#include <set>

#include "common/depth_codec/crc32c.h"
#include "common/depth_codec/depth_palette.h"
#include "common/depth_codec/depth_window.h"
#include "common/depth_codec/symbol_frequencies.h"
#include "common/rng.h"

namespace vantage {
namespace {

TEST(Crc32c, IsThatOfTheStandard) {
  const std::string digits = "123456789";
  const std::vector<uint8_t> bytes(digits.begin(), digits.end());
  EXPECT_EQ(Crc32c(bytes), 0xe3069283U);
  EXPECT_EQ(Crc32c(std::vector<uint8_t>(32, 0)), 0x8a9136aaU);  // RFC 3720, B.4
  EXPECT_EQ(Crc32c({}), 0U);
}

TEST(Crc32c, TableAndInstructionAgree) {
  Rng rng(1);
  for (size_t size = 0; size < 40; ++size) {
    std::vector<uint8_t> bytes(size);
    for (uint8_t& byte : bytes) byte = static_cast<uint8_t>(rng.NextUint32());
    EXPECT_EQ(Crc32c(bytes), Crc32cByTable(bytes));
  }
}

void ExpectPaletteKept(const std::vector<uint16_t>& depth) {
  DepthPalette palette;
  palette.Build(depth, 1, kPortableDepthKernels);
  std::vector<uint8_t> bytes = {1, 2, 3};
  palette.Append(&bytes);
  bytes.insert(bytes.end(), {9, 8});
  std::span<const uint8_t> left = std::span<const uint8_t>(bytes).subspan(3);
  DepthPalette back;
  ASSERT_TRUE(back.Read(&left));
  EXPECT_EQ(left.size(), 2U);
  ASSERT_EQ(back.size(), palette.size());
  for (const uint16_t value : depth) EXPECT_EQ(back.values()[palette.ranks()[value]], value);
}

TEST(DepthPalette, KeepsItsValues) {
  ExpectPaletteKept({});
  ExpectPaletteKept({0, 0});
  ExpectPaletteKept({5});
  ExpectPaletteKept({1, 65535});
  ExpectPaletteKept({65535, 0, 65534});
  ExpectPaletteKept({800, 808, 816, 840, 9000});
  std::vector<uint16_t> all(65536);
  std::iota(all.begin(), all.end(), uint16_t{0});
  ExpectPaletteKept(all);
  Rng rng(2);
  for (int round = 0; round < 20; ++round) {
    std::vector<uint16_t> some(rng.Below(3000));
    for (uint16_t& value : some) {
      value = static_cast<uint16_t>(rng.Below(2) * rng.Below(1 + rng.Below(65536)));
    }
    ExpectPaletteKept(some);
  }
}

TEST(DepthPalette, HoldsTheValuesOfTheImageAlone) {
  Rng rng(4);
  DepthPalette palette;
  for (const DepthKernels& kernels : AvailableDepthKernels()) {
    for (int round = 0; round < 60; ++round) {
      const size_t width = 1 + rng.Below(90);
      std::vector<uint16_t> depth(width * (1 + rng.Below(40)));
      const uint32_t repeat = 1 + rng.Below(20);
      for (size_t i = 0; i < depth.size(); ++i) {
        const size_t before = rng.Below(2) == 0 ? 1 : width;
        const bool new_one = i < before || rng.Below(repeat) == 0;
        depth[i] = new_one ? static_cast<uint16_t>(rng.NextUint32()) : depth[i - before];
      }
      palette.Build(depth, width, kernels);
      std::set<uint16_t> values(depth.begin(), depth.end());
      values.erase(0);
      const uint16_t* first = palette.values() + 1;
      const std::vector<uint16_t> found(first, first + palette.size());
      EXPECT_EQ(found, std::vector<uint16_t>(values.begin(), values.end())) << kernels.name;
    }
  }
}

TEST(DepthPalette, RefusesWhatIsNone) {
  const auto reads = [](std::vector<uint8_t> bytes) {
    std::span<const uint8_t> left = bytes;
    return DepthPalette().Read(&left);
  };
  EXPECT_TRUE(reads({0, 0}));
  EXPECT_FALSE(reads({0}));
  EXPECT_TRUE(reads({2, 0, 5, 0, 1, 0, 0, 0}));
  EXPECT_FALSE(reads({2, 0, 5, 0, 1, 0, 0}));               // The second value is missing.
  EXPECT_FALSE(reads({2, 0, 0, 0, 1, 0, 0, 0}));            // Begins with 0.
  EXPECT_FALSE(reads({2, 0, 5, 0, 0, 0, 0, 0}));            // Steps of nothing.
  EXPECT_FALSE(reads({2, 0, 5, 0, 1, 0, 16, 0, 0, 0}));     // Too many bits.
  EXPECT_FALSE(reads({2, 0, 255, 255, 1, 0, 0, 0}));        // Beyond 65535.
  EXPECT_FALSE(reads({2, 0, 5, 0, 1, 0, 15, 0xff, 0xff}));  // Endless.
  EXPECT_FALSE(reads({255, 255, 1, 0, 1, 0, 0, 0}));        // More than there are.
}

void ExpectFrequencies(const std::vector<uint32_t>& counts) {
  std::vector<uint16_t> frequencies(counts.size());
  NormalizeFrequencies(counts, frequencies);
  EXPECT_EQ(std::accumulate(frequencies.begin(), frequencies.end(), 0U), kDepthScale);
  EXPECT_GE(*std::ranges::min_element(frequencies), 1);
  std::vector<uint8_t> bytes;
  AppendFrequencies(frequencies, &bytes);
  ASSERT_EQ(bytes.size(), counts.size());
  std::vector<uint16_t> back(counts.size());
  ASSERT_TRUE(ReadFrequencies(bytes, back));
  EXPECT_EQ(back, frequencies);
}

TEST(DepthWindow, HoldsWhatIsMeasuredAndNoMore) {
  Rng rng(4);
  for (int round = 0; round < 3000; ++round) {
    const size_t width = 1 + rng.Below(9);
    const size_t height = 1 + rng.Below(7);
    std::vector<uint16_t> depth(width * height, 0);
    for (uint32_t i = rng.Below(4); i > 0; --i) {
      depth[rng.Below(static_cast<uint32_t>(depth.size()))] = 500;
    }
    size_t left = width;
    size_t right = 0;
    size_t top = height;
    size_t bottom = 0;
    for (size_t i = 0; i < depth.size(); ++i) {
      if (depth[i] == 0) continue;
      left = std::min(left, i % width);
      right = std::max(right, i % width + 1);
      top = std::min(top, i / width);
      bottom = std::max(bottom, i / width + 1);
    }
    if (right == 0) left = top = 0, right = bottom = 1;
    const DepthWindow window = FindDepthWindow(depth, width);
    EXPECT_EQ(window.left, left);
    EXPECT_EQ(window.top, top);
    EXPECT_EQ(window.width, right - left);
    EXPECT_EQ(window.height, bottom - top);
  }
}

TEST(SymbolFrequencies, SumUpAndComeBack) {
  ExpectFrequencies({0, 0, 0, 0, 0, 0, 0, 0});
  ExpectFrequencies({0, 0, 0, 1000000, 0, 0, 0, 0});
  ExpectFrequencies({1, 1, 1, 1, 1, 1, 1, 1});
  ExpectFrequencies({4000000000U, 4000000000U, 4000000000U, 1, 1, 1, 1, 4000000000U});
  ExpectFrequencies(std::vector<uint32_t>(kDepthBuckets, 1000));
  Rng rng(3);
  for (int round = 0; round < 2000; ++round) {
    std::vector<uint32_t> counts(round % 2 == 0 ? kDepthSymbols : kDepthBuckets);
    for (uint32_t& count : counts) count = rng.Below(1U << rng.Below(20));
    ExpectFrequencies(counts);
  }
}

TEST(SymbolFrequencies, AreNearTheCounts) {
  const std::vector<uint32_t> counts = {10, 20, 100, 1000, 150, 17, 3, 40};
  std::vector<uint16_t> frequencies(counts.size());
  NormalizeFrequencies(counts, frequencies);
  for (size_t i = 0; i < counts.size(); ++i) {
    EXPECT_NEAR(frequencies[i] * 1340.0 / kDepthScale, counts[i], 0.12 * counts[i]);
  }
}

TEST(SymbolFrequencies, RefusesWhatIsNone) {
  std::vector<uint16_t> frequencies(3);
  EXPECT_TRUE(ReadFrequencies(std::vector<uint8_t>{0, 0, 0}, frequencies));
  EXPECT_FALSE(ReadFrequencies(std::vector<uint8_t>{3, 0, 0}, frequencies));
  EXPECT_FALSE(ReadFrequencies(std::vector<uint8_t>{0, 56, 0}, frequencies));
  EXPECT_FALSE(ReadFrequencies(std::vector<uint8_t>{0, 55, 52}, frequencies));
}

}  // namespace
}  // namespace vantage
