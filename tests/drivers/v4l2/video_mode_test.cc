#include "drivers/v4l2/video_mode.h"

#include <gtest/gtest.h>
#include <linux/videodev2.h>

namespace vantage {
namespace {

ModeRange Exactly(double value) { return {value, value, 0.0}; }

VideoSize Vga(double rate) { return {Exactly(640), Exactly(480), {Exactly(rate)}}; }

const std::vector<VideoFormat> kWebcam = {
    {V4L2_PIX_FMT_MJPEG, "Motion-JPEG", {Vga(30), {Exactly(1280), Exactly(720), {Exactly(30)}}}},
    {V4L2_PIX_FMT_YUYV,
     "YUYV 4:2:2",
     {{Exactly(640), Exactly(480), {Exactly(30), Exactly(15)}},
      {Exactly(1280), Exactly(720), {Exactly(7.5)}}}},
    {V4L2_PIX_FMT_H264, "H.264", {Vga(30)}},
};

StreamRequest Request(int width, int height, int fps) {
  StreamRequest request;
  request.width = width;
  request.height = height;
  request.fps = fps;
  return request;
}

// Its name, or the sentence why there is none.
std::string Choice(const std::vector<VideoFormat>& formats,
                   const StreamRequest& request,
                   const std::string& wanted = "auto") {
  const Result<const PixelFormat*> chosen = ChooseFormat(formats, wanted, request, "/dev/video0");
  return chosen.ok() ? (*chosen)->name : chosen.error().message;
}

TEST(ChooseFormat, TakesTheBestThatHasSizeAndRate) {
  EXPECT_EQ(Choice(kWebcam, Request(640, 480, 30)), "YUYV");
  EXPECT_EQ(Choice(kWebcam, Request(1280, 720, 30)), "MJPG");
  EXPECT_EQ(Choice(kWebcam, Request(640, 480, 30), "MJPG"), "MJPG");
}

TEST(ChooseFormat, TakesDepthFirstAndWhatOnlyMayBeDepthLast) {
  std::vector<VideoFormat> formats = kWebcam;
  formats.push_back({V4L2_PIX_FMT_Y16, "16-bit Greyscale", {Vga(30)}});
  formats.push_back({V4L2_PIX_FMT_Y10BPACK, "10-bit Greyscale (Packed)", {Vga(30)}});
  EXPECT_EQ(Choice(formats, Request(640, 480, 30)), "YUYV");
  formats.push_back({V4L2_PIX_FMT_Z16, "16-bit Depth", {Vga(30)}});
  EXPECT_EQ(Choice(formats, Request(640, 480, 30)), "Z16");
  EXPECT_EQ(Choice({formats[3]}, Request(640, 480, 30)), "Y16");
  EXPECT_EQ(Choice({formats[4]}, Request(640, 480, 30)), "Y10B");
}

TEST(ChooseFormat, NamesWhatThereIs) {
  EXPECT_EQ(Choice(kWebcam, Request(800, 600, 30)),
            "device /dev/video0 has no format known here of 800x600 at 30 Hz, expected one of: "
            "MJPG (640x480 at 30 Hz, 1280x720 at 30 Hz), YUYV (640x480 at 30, 15 Hz, 1280x720 at "
            "7.5 Hz); not known here: H264");
  EXPECT_TRUE(Choice(kWebcam, Request(640, 480, 30), "Z16")
                  .starts_with("device /dev/video0 has no Z16 of 640x480 at 30 Hz, expected"));
  EXPECT_TRUE(Choice(kWebcam, Request(640, 480, 25)).starts_with("device /dev/video0 has no"));
  EXPECT_TRUE(Choice({}, Request(640, 480, 30)).ends_with("expected one of: none"));
}

TEST(ChooseFormat, JpegIsOnlyHadFromJpeg) {
  StreamRequest request = Request(640, 480, 30);
  request.color_layout = PixelLayout::kJpeg;
  EXPECT_EQ(Choice(kWebcam, request), "MJPG");
  EXPECT_NE(Choice({kWebcam[1]}, request).find("that is JPEG, as color_encoding wants it"),
            std::string::npos);
  EXPECT_EQ(Choice({{V4L2_PIX_FMT_Z16, "", {Vga(30)}}}, request), "Z16");
}

TEST(ChooseFormat, WhatADriverDoesNotTellIsTried) {
  EXPECT_EQ(Choice({{V4L2_PIX_FMT_Y10BPACK, "", {}}}, Request(640, 480, 30)), "Y10B");
  EXPECT_EQ(
      Choice({{V4L2_PIX_FMT_YUYV, "", {{Exactly(640), Exactly(480), {}}}}}, Request(640, 480, 30)),
      "YUYV");
}

TEST(ChooseFormat, RangesAndTheRatesOfTelevision) {
  const std::vector<VideoFormat> formats = {
      {V4L2_PIX_FMT_UYVY, "", {{{16, 1920, 16}, {16, 1080, 2}, {{5, 30, 0}}}}}};
  EXPECT_EQ(Choice(formats, Request(640, 480, 17)), "UYVY");
  EXPECT_TRUE(
      Choice(formats, Request(641, 480, 17)).ends_with("UYVY (16-1920x16-1080 at 5-30 Hz)"));
  EXPECT_TRUE(Choice(formats, Request(640, 1082, 17)).starts_with("device"));
  EXPECT_TRUE(Choice(formats, Request(640, 480, 31)).starts_with("device"));
  EXPECT_EQ(Choice({{V4L2_PIX_FMT_UYVY, "", {Vga(30000.0 / 1001.0)}}}, Request(640, 480, 30)),
            "UYVY");
}

TEST(PixelFormat, NamesAreThoseOfTheirCharacters) {
  EXPECT_EQ(PixelFormatNames().size(), 11U);
  for (const std::string& name : PixelFormatNames()) {
    const PixelFormat* format = FindPixelFormat(name);
    ASSERT_NE(format, nullptr) << name;
    EXPECT_EQ(FourccText(format->fourcc), name);
    EXPECT_EQ(FindPixelFormat(format->fourcc), format);
  }
  EXPECT_EQ(FindPixelFormat(std::string("auto")), nullptr);
  EXPECT_EQ(FindPixelFormat(uint32_t{0}), nullptr);
  EXPECT_EQ(FourccText(0x00070a41), "A???");
  EXPECT_EQ(RowBytes(*FindPixelFormat(std::string("Y10B")), 640), 800);
  EXPECT_EQ(RowBytes(*FindPixelFormat(std::string("Y10B")), 641), 802);
}

}  // namespace
}  // namespace vantage
