#include "bus/gray_conversion.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "bus/image_conversion.h"
#include "tests/common/jpeg_encoder.h"

namespace vantage {
namespace {

constexpr int64_t kUtime = 1'700'000'000'000'000;

image_t Image(int32_t pixelformat, int width, int height, int stride, std::vector<uint8_t> data) {
  image_t image{};
  image.utime = kUtime;
  image.width = width;
  image.height = height;
  image.row_stride = stride;
  image.pixelformat = pixelformat;
  image.data = std::move(data);
  return image;
}

Result<GrayFrame> Read(image_t image, int16_t type = images_t::LEFT) {
  images_t message{};
  message.utime = kUtime;
  AppendImage(type, std::move(image), &message);
  return GrayFrameFromMessage(message);
}

TEST(GrayFrameFromMessage, ReadsGrayWithPaddedRows) {
  const auto frame = Read(Image(image_t::PIXEL_FORMAT_GRAY, 2, 2, 3, {1, 2, 99, 3, 4, 99}));
  ASSERT_TRUE(frame.ok()) << frame.error().message;
  EXPECT_EQ(frame->utime, kUtime);
  EXPECT_EQ(frame->image.pixels, (std::vector<uint8_t>{1, 2, 3, 4}));
}

TEST(GrayFrameFromMessage, ColorIsLuma) {
  const std::vector<uint8_t> data = {255, 0, 0, 0, 255, 0, 0, 0, 255, 100, 100, 100};
  const auto rgb = Read(Image(image_t::PIXEL_FORMAT_RGB, 4, 1, 12, data));
  ASSERT_TRUE(rgb.ok());
  EXPECT_EQ(rgb->image.pixels, (std::vector<uint8_t>{76, 150, 29, 100}));
  const auto bgr = Read(Image(image_t::PIXEL_FORMAT_BGR, 4, 1, 12, data));
  ASSERT_TRUE(bgr.ok());
  EXPECT_EQ(bgr->image.pixels, (std::vector<uint8_t>{29, 150, 76, 100}));
  const auto white = Read(Image(image_t::PIXEL_FORMAT_RGB, 1, 1, 3, std::vector<uint8_t>(3, 255)));
  ASSERT_TRUE(white.ok());
  EXPECT_EQ(white->image.pixels[0], 255);
}

TEST(GrayFrameFromMessage, ReadsMotionJpeg) {
  std::vector<uint8_t> orange;
  for (int i = 0; i < 32 * 16; ++i) orange.insert(orange.end(), {200, 120, 40});
  const std::vector<uint8_t> jpeg = EncodeJpeg(orange, 32, 16, 3);
  const auto frame = Read(Image(image_t::PIXEL_FORMAT_MJPEG, 32, 16, 0, jpeg));
  ASSERT_TRUE(frame.ok()) << frame.error().message;
  ASSERT_EQ(frame->image.pixels.size(), 32U * 16U);
  EXPECT_EQ(frame->image.height, 16);
  for (const uint8_t luma : frame->image.pixels) EXPECT_LE(std::abs(luma - 135), 2);

  const std::vector<uint8_t> half(jpeg.begin(),
                                  jpeg.begin() + static_cast<std::ptrdiff_t>(jpeg.size() / 2));
  for (const image_t& wrong : {Image(image_t::PIXEL_FORMAT_MJPEG, 32, 16, 0, half),
                               Image(image_t::PIXEL_FORMAT_MJPEG, 16, 16, 0, jpeg),
                               Image(image_t::PIXEL_FORMAT_MJPEG, -32, 16, 0, jpeg),
                               Image(image_t::PIXEL_FORMAT_MJPEG, 4096, 4096, 0, jpeg),
                               Image(image_t::PIXEL_FORMAT_MJPEG, 1 << 30, 1 << 30, 0, jpeg)}) {
    const auto read = Read(wrong);
    ASSERT_FALSE(read.ok());
    EXPECT_NE(read.error().message.find("JPEG image of "), std::string::npos);
  }
}

TEST(GrayFrameFromMessage, RefusesSizesThatDoNotFitTheBytes) {
  const std::vector<uint8_t> six(6, 0);
  EXPECT_TRUE(Read(Image(image_t::PIXEL_FORMAT_GRAY, 3, 2, 3, six)).ok());
  const std::vector<image_t> wrong = {
      Image(image_t::PIXEL_FORMAT_GRAY, 4, 2, 3, six),
      Image(image_t::PIXEL_FORMAT_GRAY, 3, 3, 3, six),
      Image(image_t::PIXEL_FORMAT_RGB, 3, 2, 3, six),
      Image(image_t::PIXEL_FORMAT_GRAY, -3, -2, 3, six),
      Image(image_t::PIXEL_FORMAT_GRAY, 3, 2, -3, six),
      Image(image_t::PIXEL_FORMAT_GRAY, 0x40000000, 2, 0x40000000, six),
      Image(image_t::PIXEL_FORMAT_GRAY, 0, 0, 0, {})};
  for (const image_t& image : wrong) {
    const auto read = Read(image);
    ASSERT_FALSE(read.ok());
    EXPECT_NE(read.error().message.find("expected sides of 1 to"), std::string::npos);
  }
}

TEST(GrayFrameFromMessage, NamesWhatItCanNotRead) {
  const auto format = Read(Image(image_t::PIXEL_FORMAT_UYVY, 1, 1, 2, {0, 0}));
  ASSERT_FALSE(format.ok());
  EXPECT_NE(format.error().message.find("expected gray, RGB, BGR or MJPEG"), std::string::npos);
  const auto depth = Read(Image(image_t::PIXEL_FORMAT_GRAY, 1, 1, 1, {0}), images_t::DEPTH_MM);
  ASSERT_FALSE(depth.ok());
  EXPECT_NE(depth.error().message.find("color = true"), std::string::npos);
  images_t late{};
  late.utime = -1;
  EXPECT_FALSE(GrayFrameFromMessage(late).ok());
}

}  // namespace
}  // namespace vantage
