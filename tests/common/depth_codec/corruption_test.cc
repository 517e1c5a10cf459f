// What is no payload, or one that was damaged, is refused with a sentence.
#include <gtest/gtest.h>

#include "common/depth_codec/crc32c.h"
#include "common/depth_codec/depth_decoder.h"
#include "common/depth_codec/depth_encoder.h"
#include "tests/common/depth_codec/support/depth_images.h"

namespace vantage {
namespace {

constexpr int kWidth = 48;
constexpr int kHeight = 9;

std::vector<uint8_t> SoundPayload() {
  Rng rng(1);
  return DepthEncoder().Encode(
      kWidth, kHeight, StructuredLightDepth(kWidth, kHeight, 0.4, rng).depth);
}

std::string ErrorOf(std::span<const uint8_t> payload, int width = kWidth, int height = kHeight) {
  // A copy of its own, so that ASan sees the first byte that is read too far.
  const std::vector<uint8_t> bytes(payload.begin(), payload.end());
  std::vector<uint16_t> depth;
  static DepthDecoder decoder;
  const Result<void> result = decoder.Decode(bytes, width, height, &depth);
  return result ? "" : result.error().message;
}

void MendChecksum(std::vector<uint8_t>* payload) {
  const uint32_t checksum = Crc32c(std::span(*payload).subspan(8));
  for (size_t i = 0; i < 4; ++i) (*payload)[4 + i] = static_cast<uint8_t>(checksum >> (8 * i));
}

TEST(DamagedDepth, EveryChangedByteIsFound) {
  std::vector<uint8_t> payload = SoundPayload();
  ASSERT_EQ(ErrorOf(payload), "");
  ASSERT_EQ(payload[12], static_cast<uint8_t>(DepthMode::kCoded));
  for (uint8_t& byte : payload) {
    const uint8_t sound = byte;
    for (uint32_t change = 1; change < 256; ++change) {
      byte = static_cast<uint8_t>(sound ^ change);
      EXPECT_NE(ErrorOf(payload), "") << &byte - payload.data();
    }
    byte = sound;
  }
}

TEST(DamagedDepth, EveryTruncationIsFound) {
  std::vector<uint8_t> payload = SoundPayload();
  for (size_t size = 0; size < payload.size(); ++size) {
    std::vector<uint8_t> cut(payload.begin(), payload.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_NE(ErrorOf(cut), "") << size;
    if (size < kDepthHeaderBytes) continue;
    MendChecksum(&cut);
    EXPECT_NE(ErrorOf(cut), "") << size << " with a right checksum";
  }
}

TEST(DamagedDepth, BytesAtTheEndAreFound) {
  std::vector<uint8_t> payload = SoundPayload();
  payload.insert(payload.end(), 2, 0);
  MendChecksum(&payload);
  EXPECT_NE(ErrorOf(payload), "");
}

TEST(DamagedDepth, SaysWhatIsWrong) {
  const std::vector<uint8_t> sound = SoundPayload();
  EXPECT_NE(ErrorOf({}).find("expected a header of 13"), std::string::npos);
  std::vector<uint8_t> other = sound;
  other[3] = 2;
  EXPECT_NE(ErrorOf(other).find("version 1"), std::string::npos);
  other = sound;
  other[100] ^= 1;
  EXPECT_NE(ErrorOf(other).find("checksum"), std::string::npos);
  EXPECT_NE(ErrorOf(sound, 640, 480).find("48 x 9 px, expected 640 x 480"), std::string::npos);
  other = sound;
  other[12] = 7;
  MendChecksum(&other);
  EXPECT_NE(ErrorOf(other).find("mode is 7"), std::string::npos);
  other[12] = static_cast<uint8_t>(DepthMode::kStored);
  MendChecksum(&other);
  EXPECT_NE(ErrorOf(other).find("expected 864"), std::string::npos);
}

TEST(DamagedDepth, AWindowThatLeavesTheImageIsRefused) {
  std::vector<uint16_t> depth(size_t{kWidth} * kHeight, 0);
  for (size_t i = 0; i < 12; ++i) depth[5 * kWidth + 20 + i] = static_cast<uint16_t>(700 + i);
  const std::vector<uint8_t> sound = DepthEncoder().Encode(kWidth, kHeight, depth);
  ASSERT_EQ(sound[12], static_cast<uint8_t>(DepthMode::kWindow));
  ASSERT_EQ(ErrorOf(sound), "");
  // Left, top, width, height; each as 0 and too large by one.
  const struct {
    size_t byte;
    uint8_t value;
  } changes[] = {{13, 37}, {15, 9}, {17, 0}, {17, 29}, {19, 0}, {19, 5}, {18, 255}, {14, 255}};
  for (const auto& change : changes) {
    std::vector<uint8_t> payload = sound;
    payload[change.byte] = change.value;
    MendChecksum(&payload);
    EXPECT_NE(ErrorOf(payload).find("its window is"), std::string::npos) << ErrorOf(payload);
  }
}

TEST(DamagedDepth, ForgedBytesHarmNothing) {
  // Whoever makes up bytes can make up a checksum too. What decodes then is an image of the right
  // size.
  const std::vector<uint8_t> sound = SoundPayload();
  size_t refused = 0;
  size_t all = 0;
  for (const DepthKernels& kernels : AvailableDepthKernels()) {
    DepthDecoder decoder(kernels);
    for (size_t i = 8; i < sound.size(); ++i) {
      for (const int change : {1, 2, 16, 128, 255}) {
        std::vector<uint8_t> payload = sound;
        payload[i] = static_cast<uint8_t>(payload[i] ^ change);
        MendChecksum(&payload);
        std::vector<uint16_t> depth;
        const bool decoded = decoder.Decode(payload, kWidth, kHeight, &depth).ok();
        EXPECT_TRUE(!decoded || depth.size() == size_t{kWidth} * kHeight);
        refused += decoded ? 0 : 1;
        ++all;
      }
    }
  }
  // The coder's states and words must end where they should: nearly nothing passes.
  EXPECT_GT(refused, all * 8 / 10);
}

}  // namespace
}  // namespace vantage
