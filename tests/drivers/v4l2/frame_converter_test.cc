#include "drivers/v4l2/frame_converter.h"

#include <gtest/gtest.h>

#include <cstring>

#include "common/format.h"
#include "drivers/camera/frame_conversion.h"
#include "tests/common/jpeg_encoder.h"

namespace vantage {
namespace {

constexpr int kWidth = 16;
constexpr int kHeight = 8;

using Bytes = std::vector<uint8_t>;

StreamFormat FormatOf(const char* name, int64_t padding = 0) {
  StreamFormat format;
  format.pixel = FindPixelFormat(std::string(name));
  format.width = kWidth;
  format.height = kHeight;
  if (format.pixel->bits == 0) return format;
  const int64_t row = RowBytes(*format.pixel, kWidth);
  format.stride_bytes = row + padding;
  format.image_bytes = format.stride_bytes * (kHeight - 1) + row;
  return format;
}

Bytes Counting(int64_t size) {
  Bytes bytes(static_cast<size_t>(size));
  for (size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<uint8_t>(37 * i + i / 256);
  return bytes;
}

Bytes Copy(const RawImage& image) {
  Bytes bytes(image.data.size());
  std::memcpy(bytes.data(), image.data.data(), bytes.size());
  return bytes;
}

std::span<const std::byte> Span(const Bytes& bytes) { return std::as_bytes(std::span(bytes)); }

// As the camera checks it.
void ExpectTaken(const RawImage& image) {
  RawFrame frame;
  StreamDetails details;
  details.width = kWidth;
  details.height = kHeight;
  details.has_depth = image.layout == PixelLayout::kDepth16;
  (details.has_depth ? frame.depth : frame.color) = image;
  EXPECT_EQ(FrameFault(frame, details), "");
}

TEST(FrameConverter, EveryFormatInEveryLayoutIsTakenByTheCamera) {
  for (const char* name : {"Z16", "Y16", "Y10B", "YUYV", "UYVY", "RGB3", "BGR3", "GRBG", "GREY"}) {
    for (const PixelLayout layout : {PixelLayout::kRgb8, PixelLayout::kGray8}) {
      for (const int64_t padding : {0, 6}) {
        SCOPED_TRACE(std::string(name) + (padding == 0 ? "" : " padded"));
        const StreamFormat format = FormatOf(name, padding);
        FrameConverter converter(format, layout, {});
        RawImage image;
        EXPECT_EQ(converter.Convert(Span(Counting(format.image_bytes + 3)), &image), "");
        ExpectTaken(image);
      }
    }
  }
}

TEST(FrameConverter, DepthWithoutPaddingIsNotCopied) {
  const StreamFormat format = FormatOf("Z16");
  FrameConverter converter(format, PixelLayout::kRgb8, {});
  const Bytes bytes = Counting(format.image_bytes + 100);
  RawImage image;
  ASSERT_EQ(converter.Convert(Span(bytes), &image), "");
  EXPECT_EQ(image.data.data(), Span(bytes).data());
  EXPECT_EQ(image.data.size(), size_t{2} * kWidth * kHeight);
}

TEST(FrameConverter, PaddingIsLeftOut) {
  const StreamFormat format = FormatOf("Z16", 10);
  FrameConverter converter(format, PixelLayout::kRgb8, {});
  const Bytes bytes = Counting(format.image_bytes);
  RawImage image;
  ASSERT_EQ(converter.Convert(Span(bytes), &image), "");
  const Bytes packed = Copy(image);
  for (size_t v = 0; v < kHeight; ++v) {
    for (size_t i = 0; i < 2 * kWidth; ++i) {
      ASSERT_EQ(packed[2 * kWidth * v + i], bytes[(2 * kWidth + 10) * v + i]);
    }
  }
}

TEST(FrameConverter, DisparityBecomesMillimetres) {
  const StreamFormat format = FormatOf("Y10B");
  const DisparityModel model;
  FrameConverter converter(format, PixelLayout::kRgb8, model);
  Bytes bytes(static_cast<size_t>(format.image_bytes), 0xff);
  // Four pixels of 600, 700, 800, 900: 1001011000 1010111100 1100100000 1110000100.
  const Bytes four = {0b10010110, 0b00101011, 0b11001100, 0b10000011, 0b10000100};
  std::ranges::copy(four, bytes.begin());
  RawImage image;
  ASSERT_EQ(converter.Convert(Span(bytes), &image), "");
  std::array<uint16_t, 5> depth_mm{};
  std::memcpy(depth_mm.data(), image.data.data(), sizeof(depth_mm));
  EXPECT_EQ(
      depth_mm,
      (std::array<uint16_t, 5>{
          model.DepthMm(600), model.DepthMm(700), model.DepthMm(800), model.DepthMm(900), 0}));
}

TEST(FrameConverter, ShortImagesAreFaults) {
  for (const char* name : {"Z16", "Y10B", "YUYV", "GRBG", "GREY"}) {
    const StreamFormat format = FormatOf(name, 4);
    FrameConverter converter(format, PixelLayout::kRgb8, {});
    RawImage image;
    EXPECT_EQ(converter.Convert(Span(Counting(format.image_bytes - 1)), &image),
              Format("a short image of %lld bytes, expected at least %lld",
                     static_cast<long long>(format.image_bytes - 1),
                     static_cast<long long>(format.image_bytes)));
    EXPECT_NE(converter.Convert({}, &image), "");
  }
}

TEST(FrameConverter, ColorsAreThoseOfTheFormat) {
  // All of one color: R 255, G 0, B 0.
  const auto first_pixel = [](const char* name, const Bytes& pattern, PixelLayout layout) {
    const StreamFormat format = FormatOf(name);
    Bytes bytes;
    while (bytes.size() < static_cast<size_t>(format.image_bytes)) {
      bytes.insert(bytes.end(), pattern.begin(), pattern.end());
    }
    FrameConverter converter(format, layout, {});
    RawImage image;
    EXPECT_EQ(converter.Convert(Span(bytes), &image), "");
    Bytes pixel = Copy(image);
    pixel.resize(layout == PixelLayout::kGray8 ? 1 : 3);
    return pixel;
  };
  const Bytes red = {255, 0, 0};
  EXPECT_EQ(first_pixel("RGB3", red, PixelLayout::kRgb8), red);
  EXPECT_EQ(first_pixel("BGR3", {0, 0, 255}, PixelLayout::kRgb8), red);
  const Bytes yuv = first_pixel("YUYV", {81, 90, 81, 240}, PixelLayout::kRgb8);
  EXPECT_GE(yuv[0], 253);
  EXPECT_LE(yuv[1], 2);
  EXPECT_LE(yuv[2], 2);
  for (const char* name : {"RGB3", "BGR3"}) {
    const Bytes pattern = std::string(name) == "RGB3" ? red : Bytes{0, 0, 255};
    EXPECT_EQ(first_pixel(name, pattern, PixelLayout::kGray8), Bytes{76}) << name;
  }
  EXPECT_EQ(first_pixel("YUYV", {81, 90, 81, 240}, PixelLayout::kGray8), Bytes{76});
  EXPECT_EQ(first_pixel("UYVY", {90, 81, 240, 81}, PixelLayout::kGray8), Bytes{76});
  EXPECT_EQ(first_pixel("GREY", {76}, PixelLayout::kGray8), Bytes{76});
}

Bytes Jpeg(int width, int height) {
  return EncodeJpeg(Bytes(static_cast<size_t>(3 * width * height), 120), width, height, 3);
}

TEST(FrameConverter, JpegIsDecodedOrPassedOn) {
  const Bytes jpeg = Jpeg(kWidth, kHeight);
  RawImage image;
  FrameConverter rgb(FormatOf("MJPG"), PixelLayout::kRgb8, {});
  ASSERT_EQ(rgb.Convert(Span(jpeg), &image), "");
  ExpectTaken(image);
  for (const uint8_t byte : Copy(image)) ASSERT_NEAR(byte, 120, 2);
  FrameConverter gray(FormatOf("MJPG"), PixelLayout::kGray8, {});
  ASSERT_EQ(gray.Convert(Span(jpeg), &image), "");
  ExpectTaken(image);
  FrameConverter passed(FormatOf("MJPG"), PixelLayout::kJpeg, {});
  Bytes padded = jpeg;
  padded.resize(padded.size() + 100);
  ASSERT_EQ(passed.Convert(Span(padded), &image), "");
  ExpectTaken(image);
  EXPECT_EQ(Copy(image), jpeg);
}

TEST(FrameConverter, TruncatedJpegIsAFault) {
  const Bytes jpeg = Jpeg(kWidth, kHeight);
  FrameConverter rgb(FormatOf("MJPG"), PixelLayout::kRgb8, {});
  FrameConverter passed(FormatOf("MJPG"), PixelLayout::kJpeg, {});
  for (size_t size = 0; size + 2 <= jpeg.size(); ++size) {
    const Bytes cut(jpeg.begin(), jpeg.begin() + static_cast<std::ptrdiff_t>(size));
    RawImage image;
    EXPECT_NE(rgb.Convert(Span(cut), &image), "") << size;
    EXPECT_NE(passed.Convert(Span(cut), &image), "") << size;
  }
  RawImage image;
  EXPECT_NE(rgb.Convert(Span(Jpeg(kWidth, kHeight + 1)), &image), "");
}

}  // namespace
}  // namespace vantage
