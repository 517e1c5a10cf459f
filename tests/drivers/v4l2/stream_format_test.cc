#include "drivers/v4l2/stream_format.h"

#include <gtest/gtest.h>

namespace vantage {
namespace {

v4l2_format Answer(uint32_t fourcc, uint32_t stride, uint32_t size) {
  v4l2_format format{};
  format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  v4l2_pix_format& pix = format.fmt.pix;
  pix.width = 640;
  pix.height = 480;
  pix.pixelformat = fourcc;
  pix.field = V4L2_FIELD_NONE;
  pix.bytesperline = stride;
  pix.sizeimage = size;
  return format;
}

Result<StreamFormat> Check(const v4l2_format& answer, const char* name) {
  return CheckFormat(answer, *FindPixelFormat(std::string(name)), StreamRequest(), "/dev/video0");
}

std::string Fault(const v4l2_format& answer, const char* name) {
  const Result<StreamFormat> format = Check(answer, name);
  return format.ok() ? "" : format.error().message;
}

TEST(CheckFormat, TakesRowsWithAndWithoutPadding) {
  const Result<StreamFormat> plain = Check(Answer(V4L2_PIX_FMT_Z16, 1280, 614400), "Z16");
  ASSERT_TRUE(plain.ok());
  EXPECT_EQ(plain->stride_bytes, 1280);
  EXPECT_EQ(plain->image_bytes, 614400);
  const Result<StreamFormat> padded = Check(Answer(V4L2_PIX_FMT_Z16, 2048, 983040), "Z16");
  ASSERT_TRUE(padded.ok());
  EXPECT_EQ(padded->image_bytes, 2048 * 479 + 1280);
  const Result<StreamFormat> unsaid = Check(Answer(V4L2_PIX_FMT_Y10BPACK, 0, 384000), "Y10B");
  ASSERT_TRUE(unsaid.ok());
  EXPECT_EQ(unsaid->stride_bytes, 800);
  const Result<StreamFormat> jpeg = Check(Answer(V4L2_PIX_FMT_MJPEG, 0, 100000), "MJPG");
  ASSERT_TRUE(jpeg.ok());
  EXPECT_EQ(jpeg->image_bytes, 0);
}

TEST(CheckFormat, RefusesAbsurdSizes) {
  EXPECT_EQ(Fault(Answer(V4L2_PIX_FMT_Z16, 1279, 614400), "Z16"),
            "device /dev/video0 says that its rows are 1279 bytes apart, expected at least 1280 "
            "for 640 px");
  EXPECT_EQ(Fault(Answer(V4L2_PIX_FMT_Z16, 1280, 614399), "Z16"),
            "device /dev/video0 says that an image takes 614399 bytes, expected 614400 to "
            "268435456");
  EXPECT_NE(Fault(Answer(V4L2_PIX_FMT_Z16, 1280, 0), "Z16"), "");
  EXPECT_NE(Fault(Answer(V4L2_PIX_FMT_Z16, 1280, (256U << 20) + 1), "Z16"), "");
  EXPECT_NE(Fault(Answer(V4L2_PIX_FMT_Z16, 0xffffffffU, 0xffffffffU), "Z16"), "");
  EXPECT_NE(Fault(Answer(V4L2_PIX_FMT_Z16, 1U << 31, 614400), "Z16"), "");
  EXPECT_NE(Fault(Answer(V4L2_PIX_FMT_MJPEG, 0, 0), "MJPG"), "");
  EXPECT_NE(Fault(Answer(V4L2_PIX_FMT_MJPEG, 0, 0xffffffffU), "MJPG"), "");
}

TEST(CheckFormat, RefusesWhatWasNotAskedFor) {
  EXPECT_EQ(Fault(Answer(V4L2_PIX_FMT_YUYV, 1280, 614400), "Z16"),
            "device /dev/video0 gives YUYV of 640x480 px when asked for Z16 of 640x480 px");
  v4l2_format small = Answer(V4L2_PIX_FMT_Z16, 640, 153600);
  small.fmt.pix.width = 320;
  small.fmt.pix.height = 240;
  EXPECT_EQ(Fault(small, "Z16"),
            "device /dev/video0 gives Z16 of 320x240 px when asked for Z16 of 640x480 px");
  v4l2_format fields = Answer(V4L2_PIX_FMT_YUYV, 1280, 614400);
  fields.fmt.pix.field = V4L2_FIELD_ALTERNATE;
  EXPECT_NE(Fault(fields, "YUYV").find("interlaced"), std::string::npos);
  fields.fmt.pix.field = V4L2_FIELD_INTERLACED;
  EXPECT_EQ(Fault(fields, "YUYV"), "");
}

TEST(CheckFormat, ReadsMultiPlanarAnswersOfOnePlane) {
  v4l2_format format{};
  format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE;
  v4l2_pix_format_mplane& pix = format.fmt.pix_mp;
  pix.width = 640;
  pix.height = 480;
  pix.pixelformat = V4L2_PIX_FMT_YUYV;
  pix.num_planes = 1;
  pix.plane_fmt[0].bytesperline = 1344;
  pix.plane_fmt[0].sizeimage = 1344 * 480;
  const Result<StreamFormat> read = Check(format, "YUYV");
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->stride_bytes, 1344);
  pix.num_planes = 2;
  EXPECT_EQ(Fault(format, "YUYV"), "device /dev/video0 gives images in 2 planes, expected 1");
}

TEST(CheckFormat, FollowsTheKernelsRulesOfColor) {
  const auto yuv = [](uint32_t colorspace, uint32_t encoding, uint32_t quantization) {
    v4l2_format format = Answer(V4L2_PIX_FMT_YUYV, 1280, 614400);
    format.fmt.pix.colorspace = colorspace;
    format.fmt.pix.ycbcr_enc = encoding;
    format.fmt.pix.quantization = quantization;
    return Check(format, "YUYV")->yuv;
  };
  const YuvEncoding limited_601{false, false};
  const YuvEncoding full_601{false, true};
  const YuvEncoding limited_709{true, false};
  EXPECT_EQ(yuv(V4L2_COLORSPACE_DEFAULT, 0, 0), limited_601);
  EXPECT_EQ(yuv(V4L2_COLORSPACE_SRGB, 0, 0), limited_601);
  EXPECT_EQ(yuv(V4L2_COLORSPACE_SMPTE170M, 0, 0), limited_601);
  EXPECT_EQ(yuv(V4L2_COLORSPACE_JPEG, 0, 0), full_601);
  EXPECT_EQ(yuv(V4L2_COLORSPACE_SRGB, 0, V4L2_QUANTIZATION_FULL_RANGE), full_601);
  EXPECT_EQ(yuv(V4L2_COLORSPACE_REC709, 0, 0), limited_709);
  EXPECT_EQ(yuv(V4L2_COLORSPACE_SRGB, V4L2_YCBCR_ENC_709, 0), limited_709);
  EXPECT_EQ(yuv(0xffffffffU, 0, 0), limited_601);
}

}  // namespace
}  // namespace vantage
