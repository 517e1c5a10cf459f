// Hostile payloads under every set of instructions: nothing crashes (run it under ASan and UBSan
// too), and memory follows the image that is expected, not what the bytes claim.
#include <gtest/gtest.h>

#include "common/depth_codec/crc32c.h"
#include "common/depth_codec/depth_decoder.h"
#include "common/depth_codec/depth_encoder.h"
#include "tests/bus/fuzz/count_allocations.h"
#include "tests/common/depth_codec/support/depth_images.h"

namespace vantage {
namespace {

constexpr size_t kPerPixel = 32;       // Bytes, with all buffers.
constexpr size_t kPerByte = 2;         // Of the payload.
constexpr size_t kConstant = 100'000;  // Bytes; what a row needs, and an error's sentence.

void MendChecksum(std::vector<uint8_t>* payload) {
  if (payload->size() < kDepthHeaderBytes) return;
  const uint32_t checksum = Crc32c(std::span(*payload).subspan(8));
  for (size_t i = 0; i < 4; ++i) (*payload)[4 + i] = static_cast<uint8_t>(checksum >> (8 * i));
}

class DepthCodecFuzz : public testing::TestWithParam<DepthKernels> {
 protected:
  // With the right checksum, in memory of exactly its size.
  void Feed(std::vector<uint8_t> payload, int width, int height) {
    MendChecksum(&payload);
    const std::vector<uint8_t> bytes(payload.begin(), payload.end());
    const size_t pixels = static_cast<size_t>(width) * static_cast<size_t>(height);
    std::vector<uint16_t> depth;
    const size_t before = BytesAllocated();
    const Result<void> result = decoder_.Decode(bytes, width, height, &depth);
    EXPECT_LE(BytesAllocated() - before, kPerPixel * pixels + kPerByte * bytes.size() + kConstant);
    EXPECT_TRUE(!result || depth.size() == pixels);
  }

  DepthDecoder decoder_{GetParam()};
};

TEST_P(DepthCodecFuzz, SurvivesFlips) {
  Rng rng(1);
  for (const TestDepth& image : AdversarialDepths(rng)) {
    const auto sound = DepthEncoder(GetParam()).Encode(image.width, image.height, image.depth);
    for (int round = 0; round < 60; ++round) {
      std::vector<uint8_t> payload = sound;
      const uint32_t flips = 1 + rng.Below(4);
      for (uint32_t i = 0; i < flips; ++i) {
        // Half of them where the tables are.
        const auto size = static_cast<uint32_t>(payload.size());
        const uint32_t end = rng.Below(2) == 0 ? size : std::min(size, 420U);
        payload[rng.Below(end)] ^= static_cast<uint8_t>(1U << rng.Below(8));
      }
      Feed(std::move(payload), image.width, image.height);
    }
  }
}

TEST_P(DepthCodecFuzz, SurvivesRandomBytesAfterASoundHead) {
  Rng rng(2);
  const TestDepth image = StructuredLightDepth(100, 30, 0.5, rng);
  const auto sound = DepthEncoder(GetParam()).Encode(image.width, image.height, image.depth);
  for (int round = 0; round < 2000; ++round) {
    const size_t keep = kDepthHeaderBytes + rng.Below(500);
    std::vector<uint8_t> payload(
        sound.begin(), sound.begin() + static_cast<std::ptrdiff_t>(std::min(keep, sound.size())));
    const uint32_t more = rng.Below(1500);
    for (uint32_t i = 0; i < more; ++i) {
      payload.push_back(static_cast<uint8_t>(rng.Below(1 + rng.Below(256))));
    }
    Feed(std::move(payload), image.width, image.height);
  }
}

TEST_P(DepthCodecFuzz, SurvivesTruncations) {
  Rng rng(3);
  const TestDepth image = StructuredLightDepth(70, 21, 4.0, rng);
  const auto sound = DepthEncoder(GetParam()).Encode(image.width, image.height, image.depth);
  for (size_t size = 0; size < sound.size(); ++size) {
    Feed({sound.begin(), sound.begin() + static_cast<std::ptrdiff_t>(size)}, 70, 21);
  }
}

TEST_P(DepthCodecFuzz, AllocatesNothingOnceWarm) {
  Rng rng(4);
  std::vector<TestDepth> images;
  for (int i = 0; i < 4; ++i) images.push_back(StructuredLightDepth(320, 100, 0.4, rng));
  DepthEncoder encoder(GetParam());
  std::vector<uint8_t> payload;
  std::vector<uint16_t> depth;
  size_t before = 0;
  for (int round = 0; round < 200; ++round) {
    if (round == 8) before = BytesAllocated();
    const TestDepth& image = images[static_cast<size_t>(round % 4)];
    encoder.Encode(320, 100, image.depth, &payload);
    ASSERT_TRUE(decoder_.Decode(payload, 320, 100, &depth));
  }
  EXPECT_EQ(BytesAllocated() - before, 0U);
}

INSTANTIATE_TEST_SUITE_P(On,
                         DepthCodecFuzz,
                         testing::ValuesIn(AvailableDepthKernels().begin(),
                                           AvailableDepthKernels().end()),
                         [](const auto& kernels) { return std::string(kernels.param.name); });

}  // namespace
}  // namespace vantage
