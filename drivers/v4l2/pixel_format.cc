#include "drivers/v4l2/pixel_format.h"

#include <linux/videodev2.h>

#include <algorithm>
#include <array>

namespace vantage {
namespace {

using Kind = PixelFormat::Kind;

// In the order in which they are preferred where the configuration leaves the choice: what is
// surely depth, then color that needs no decoding and has most of it. Y10B is raw disparity of a
// Kinect in its depth mode, which has no other format, but in its other mode an infrared image;
// Y16 is an infrared or thermal image on many devices.
constexpr std::array kFormats = {
    PixelFormat{V4L2_PIX_FMT_Z16, "Z16", Kind::kDepth, 16},
    PixelFormat{V4L2_PIX_FMT_YUYV, "YUYV", Kind::kColor, 16},
    PixelFormat{V4L2_PIX_FMT_UYVY, "UYVY", Kind::kColor, 16},
    PixelFormat{V4L2_PIX_FMT_RGB24, "RGB3", Kind::kColor, 24},
    PixelFormat{V4L2_PIX_FMT_BGR24, "BGR3", Kind::kColor, 24},
    PixelFormat{V4L2_PIX_FMT_SGRBG8, "GRBG", Kind::kColor, 8},
    PixelFormat{V4L2_PIX_FMT_MJPEG, "MJPG", Kind::kColor, 0},
    PixelFormat{V4L2_PIX_FMT_JPEG, "JPEG", Kind::kColor, 0},
    PixelFormat{V4L2_PIX_FMT_GREY, "GREY", Kind::kColor, 8},
    PixelFormat{V4L2_PIX_FMT_Y10BPACK, "Y10B", Kind::kDepth, 10},
    PixelFormat{V4L2_PIX_FMT_Y16, "Y16", Kind::kDepth, 16},
};

template <class Predicate>
const PixelFormat* Find(const Predicate& predicate) {
  const auto* found = std::ranges::find_if(kFormats, predicate);
  return found == kFormats.end() ? nullptr : found;
}

}  // namespace

const PixelFormat* FindPixelFormat(uint32_t fourcc) {
  return Find([fourcc](const PixelFormat& format) { return format.fourcc == fourcc; });
}

const PixelFormat* FindPixelFormat(const std::string& name) {
  return Find([&name](const PixelFormat& format) { return format.name == name; });
}

std::vector<std::string> PixelFormatNames() {
  std::vector<std::string> names;
  for (const PixelFormat& format : kFormats) names.emplace_back(format.name);
  return names;
}

std::string FourccText(uint32_t fourcc) {
  std::string text;
  for (int shift = 0; shift < 32; shift += 8) {
    const char c = static_cast<char>((fourcc >> shift) & 0x7f);
    text += c >= ' ' && c <= '~' ? c : '?';
  }
  text.erase(text.find_last_not_of(' ') + 1);
  return text;
}

int64_t RowBytes(const PixelFormat& format, int width) {
  return (static_cast<int64_t>(width) * format.bits + 7) / 8;
}

}  // namespace vantage
