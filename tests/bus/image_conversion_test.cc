#include "bus/image_conversion.h"

#include <gtest/gtest.h>

#include <functional>

#include "bus/message_check.h"
#include "common/rng.h"

namespace vantage {
namespace {

constexpr int kWidth = 31;
constexpr int kHeight = 17;

std::vector<uint16_t> SomeDepth() {
  Rng rng(4);
  std::vector<uint16_t> millimetres(kWidth * kHeight);
  for (uint16_t& value : millimetres) value = static_cast<uint16_t>(rng.Below(5) * 16'000);
  return millimetres;
}

images_t SomeMessage(DepthCompression compression) {
  return DepthToMessage(kWidth, kHeight, SomeDepth(), 11, 0x0102030405060708, "S1", compression);
}

class DepthConversion : public testing::TestWithParam<DepthCompression> {};

TEST_P(DepthConversion, RoundTripsOverTheWire) {
  const Result<images_t> message = DecodeChecked<images_t>(Encode(SomeMessage(GetParam())));
  ASSERT_TRUE(message.ok()) << message.error().message;
  const Result<DepthFrame> frame = DepthFrameFromMessage(message.value());
  ASSERT_TRUE(frame.ok()) << frame.error().message;
  EXPECT_EQ(frame->utime, 11);
  EXPECT_EQ(frame->seq, 0x0102030405060708);
  EXPECT_EQ(frame->serial, "S1");
  EXPECT_EQ(frame->image.width, kWidth);
  EXPECT_EQ(frame->image.height, kHeight);
  EXPECT_EQ(DepthToMillimetres(frame->image), SomeDepth());
}

TEST_P(DepthConversion, RefusesWhatDoesNotBelongToTheSize) {
  const std::vector<std::function<void(image_t*)>> attacks = {
      [](image_t* m) { m->width = 0; },
      [](image_t* m) { m->width = -31; },
      [](image_t* m) { m->height = INT32_MAX; },
      [](image_t* m) { m->width = m->height = 4096; },
      [](image_t* m) { m->height = kHeight + 1; },
      [](image_t* m) { m->height = kHeight - 1; },
      [](image_t* m) { m->row_stride = 2 * kWidth - 2; },
      [](image_t* m) { m->row_stride = 2 * kWidth + 2; },
      [](image_t* m) { m->row_stride = INT32_MIN; },
      [](image_t* m) { m->row_stride = INT32_MAX; },
      [](image_t* m) { m->data.pop_back(); },
      [](image_t* m) { m->data.push_back(0); },
      [](image_t* m) { m->data.clear(); }};
  for (size_t i = 0; i < attacks.size(); ++i) {
    images_t message = SomeMessage(GetParam());
    attacks[i](&message.images[0]);
    EXPECT_FALSE(DepthFrameFromMessage(message).ok()) << i;
  }
}

TEST_P(DepthConversion, RefusesTimesThatAreNone) {
  for (const int64_t bad : {INT64_MIN, INT64_MAX, int64_t{-1}}) {
    images_t message = SomeMessage(GetParam());
    message.utime = bad;
    const Result<DepthFrame> frame = DepthFrameFromMessage(message);
    ASSERT_FALSE(frame.ok()) << bad;
    EXPECT_NE(frame.error().message.find("images_t.utime"), std::string::npos);
  }
}

INSTANTIATE_TEST_SUITE_P(All,
                         DepthConversion,
                         testing::Values(DepthCompression::kNone,
                                         DepthCompression::kZlib,
                                         DepthCompression::kVdc));

TEST(ImageConversion, TypesAreThoseOfTheWire) {
  EXPECT_EQ(SomeMessage(DepthCompression::kNone).image_types[0], 4);
  EXPECT_EQ(SomeMessage(DepthCompression::kZlib).image_types[0], 6);
  EXPECT_EQ(SomeMessage(DepthCompression::kVdc).image_types[0], 100);
}

TEST(ImageConversion, RawRowsMayBePadded) {
  images_t message = SomeMessage(DepthCompression::kNone);
  image_t& image = message.images[0];
  std::vector<uint8_t> padded;
  for (int v = 0; v < kHeight; ++v) {
    const auto row = image.data.begin() + v * 2 * kWidth;
    padded.insert(padded.end(), row, row + 2 * kWidth);
    padded.insert(padded.end(), 6, 0xff);
  }
  image.data = padded;
  image.row_stride += 6;
  const Result<DepthFrame> frame = DepthFrameFromMessage(message);
  ASSERT_TRUE(frame.ok()) << frame.error().message;
  EXPECT_EQ(DepthToMillimetres(frame->image), SomeDepth());
}

TEST(ImageConversion, RefusesDamagedStreams) {
  for (const DepthCompression compression : {DepthCompression::kZlib, DepthCompression::kVdc}) {
    const images_t sound = SomeMessage(compression);
    for (size_t i = 0; i < sound.images[0].data.size(); ++i) {
      images_t message = sound;
      message.images[0].data[i] ^= 0x55;
      const Result<DepthFrame> frame = DepthFrameFromMessage(message);
      // A checksum finds whatever still gives the right size.
      EXPECT_FALSE(frame.ok()) << i;
    }
  }
}

TEST(ImageConversion, FindsTheDepthAmongOthers) {
  images_t message{};
  image_t color{};
  color.data = {1, 2, 3};
  AppendImage(images_t::LEFT, color, &message);
  EXPECT_EQ(message.n_images, 1);
  EXPECT_EQ(message.images[0].size, 3);
  const Result<DepthFrame> none = DepthFrameFromMessage(message);
  ASSERT_FALSE(none.ok());
  EXPECT_EQ(none.error().code, ErrorCode::kNotFound);
  const images_t depth = SomeMessage(DepthCompression::kZlib);
  AppendImage(images_t::DEPTH_MM_ZIPPED, depth.images[0], &message);
  EXPECT_TRUE(DepthFrameFromMessage(message).ok());
}

TEST(ImageConversion, WithoutMetadataTheSeqIsUnknown) {
  images_t message = SomeMessage(DepthCompression::kNone);
  message.images[0].metadata[0].value.pop_back();
  EXPECT_EQ(ImageSeq(message.images[0]), -1);
  message.images[0].metadata.clear();
  const Result<DepthFrame> frame = DepthFrameFromMessage(message);
  ASSERT_TRUE(frame.ok());
  EXPECT_EQ(frame->seq, -1);
  EXPECT_EQ(frame->serial, "");
}

}  // namespace
}  // namespace vantage
