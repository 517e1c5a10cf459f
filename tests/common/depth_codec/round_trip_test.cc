// Every image comes back as it was, by every set of instructions, and all write the same bytes.
#include <gtest/gtest.h>

#include "common/depth_codec/depth_decoder.h"
#include "common/depth_codec/depth_encoder.h"
#include "tests/common/depth_codec/support/depth_images.h"

namespace vantage {
namespace {

class DepthCodec : public testing::TestWithParam<DepthKernels> {};

std::string KernelsName(const testing::TestParamInfo<DepthKernels>& info) {
  return info.param.name;
}

std::vector<DepthKernels> AllKernels() {
  const auto available = AvailableDepthKernels();
  return {available.begin(), available.end()};
}

void ExpectDecodes(DepthDecoder& decoder,
                   std::span<const uint8_t> payload,
                   const TestDepth& image) {
  std::vector<uint16_t> decoded(3, 12345);
  const Result<void> result = decoder.Decode(payload, image.width, image.height, &decoded);
  ASSERT_TRUE(result) << image.name << ": " << result.error().message;
  EXPECT_TRUE(decoded == image.depth) << image.name;
}

TEST_P(DepthCodec, KeepsAdversarialImages) {
  Rng rng(1);
  DepthEncoder encoder(GetParam());
  DepthDecoder decoder(GetParam());
  for (const TestDepth& image : AdversarialDepths(rng)) {
    const std::vector<uint8_t> payload = encoder.Encode(image.width, image.height, image.depth);
    ExpectDecodes(decoder, payload, image);
    EXPECT_LE(payload.size(), kDepthHeaderBytes + 2 * image.depth.size()) << image.name;
  }
}

TEST_P(DepthCodec, KeepsASequenceOfDifferentImages) {
  Rng rng(2);
  DepthEncoder encoder(GetParam());
  DepthDecoder decoder(GetParam());
  std::vector<uint8_t> payload;
  for (int round = 0; round < 70; ++round) {
    const int width = 1 + static_cast<int>(rng.Below(150));
    const int height = 1 + static_cast<int>(rng.Below(40));
    const TestDepth image = StructuredLightDepth(width, height, 0.5, rng);
    encoder.Encode(width, height, image.depth, &payload);
    ExpectDecodes(decoder, payload, image);
  }
}

TEST_P(DepthCodec, WritesAndReadsWhatThePortableLoopsDo) {
  Rng rng(3);
  std::vector<TestDepth> images = AdversarialDepths(rng);
  for (const double sigma : {0.0, 0.4, 3.0, 300.0}) {
    images.push_back(StructuredLightDepth(320, 121, sigma, rng));
  }
  DepthEncoder encoder(GetParam());
  DepthEncoder portable_encoder(kPortableDepthKernels);
  DepthDecoder decoder(GetParam());
  DepthDecoder portable_decoder(kPortableDepthKernels);
  for (const TestDepth& image : images) {
    const auto payload = encoder.Encode(image.width, image.height, image.depth);
    const auto portable = portable_encoder.Encode(image.width, image.height, image.depth);
    EXPECT_TRUE(payload == portable) << image.name;
    ExpectDecodes(portable_decoder, payload, image);
    ExpectDecodes(decoder, portable, image);
  }
}

INSTANTIATE_TEST_SUITE_P(On, DepthCodec, testing::ValuesIn(AllKernels()), KernelsName);

TEST(DepthCodecRatio, IsThatOfTheNoise) {
  Rng rng(4);
  const auto ratio = [&](double sigma) {
    const TestDepth image = StructuredLightDepth(640, 480, sigma, rng);
    const auto payload = DepthEncoder().Encode(640, 480, image.depth);
    return 2.0 * 640 * 480 / static_cast<double>(payload.size());
  };
  EXPECT_GT(ratio(0.0), 30.0);
  EXPECT_GT(ratio(0.41), 8.0);
  // Independent noise of s steps takes log2(s sqrt(2 pi e)) bits: no codec is better than that.
  EXPECT_LT(ratio(2.0), 16.0 / std::log2(2.0 * 4.133));
}

TEST(DepthCodecRatio, DoesNotDependOnTheUnit) {
  Rng rng(5);
  TestDepth image = StructuredLightDepth(320, 240, 0.4, rng);
  const size_t plain = DepthEncoder().Encode(320, 240, image.depth).size();
  for (uint16_t& value : image.depth) value = static_cast<uint16_t>(8 * value);
  const size_t scaled = DepthEncoder().Encode(320, 240, image.depth).size();
  EXPECT_NEAR(static_cast<double>(scaled), static_cast<double>(plain), 4.0);
}

TEST(DepthCodecRatio, NoiseIsStored) {
  Rng rng(6);
  std::vector<uint16_t> noise(640 * 480);
  for (uint16_t& value : noise) value = static_cast<uint16_t>(rng.NextUint32());
  EXPECT_EQ(DepthEncoder().Encode(640, 480, noise).size(), kDepthHeaderBytes + 2 * noise.size());
}

TEST(DepthCodecLimits, KeepsTheLargestImage) {
  Rng rng(7);
  const TestDepth tile = StructuredLightDepth(kMaxDepthSide, 16, 0.4, rng);
  TestDepth image{"largest", kMaxDepthSide, kMaxDepthSide, {}};
  for (int v = 0; v < kMaxDepthSide; v += 16) {
    image.depth.insert(image.depth.end(), tile.depth.begin(), tile.depth.end());
  }
  DepthEncoder encoder;
  const auto payload = encoder.Encode(image.width, image.height, image.depth);
  DepthDecoder decoder;
  ExpectDecodes(decoder, payload, image);
}

TEST(DepthCodecLimitsDeathTest, SidesAndSizesAreTheCallers) {
  EXPECT_DEATH(DepthEncoder().Encode(2, 2, std::vector<uint16_t>(3)), "width \\* height");
  EXPECT_DEATH(DepthEncoder().Encode(0, 2, {}), "width \\* height");
  std::vector<uint16_t> depth;
  EXPECT_DEATH((void)DepthDecoder().Decode({}, 4097, 1, &depth), "4096");
}

}  // namespace
}  // namespace vantage
