#include "drivers/v4l2/video_mode.h"

#include <linux/videodev2.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "common/format.h"
#include "drivers/v4l2/v4l2_ioctl.h"

namespace vantage {
namespace {

// A driver that never says "no more" must not be asked for ever: of all its lists together.
constexpr int kMostEntries = 4096;

constexpr int kMostUnknown = 8;  // formats that a message names

// 30 Hz also means the 30000/1001 Hz of television.
constexpr double kRateTolerance = 0.005;

double RateOf(const v4l2_fract& interval) {
  return interval.numerator == 0 ? 0.0
                                 : static_cast<double>(interval.denominator) / interval.numerator;
}

std::vector<ModeRange> ReadRates(
    int fd, uint32_t fourcc, uint32_t width, uint32_t height, int* entries_left) {
  std::vector<ModeRange> rates;
  for (uint32_t i = 0; --*entries_left >= 0; ++i) {
    v4l2_frmivalenum query{};
    query.index = i;
    query.pixel_format = fourcc;
    query.width = width;
    query.height = height;
    if (Ioctl(fd, VIDIOC_ENUM_FRAMEINTERVALS, &query) != 0) break;
    if (query.type == V4L2_FRMIVAL_TYPE_DISCRETE) {
      const double rate = RateOf(query.discrete);
      const ModeRange range{rate, rate, 0.0};
      if (i > 0 && range == rates.front()) break;  // The list begins again.
      rates.push_back(range);
      continue;
    }
    // The steps are those of the intervals, between any two of which drivers settle.
    rates.push_back({RateOf(query.stepwise.max), RateOf(query.stepwise.min), 0.0});
    break;
  }
  return rates;
}

VideoSize FixedSize(uint32_t width, uint32_t height) {
  const double w = width;
  const double h = height;
  return {{w, w, 0.0}, {h, h, 0.0}, {}};
}

std::vector<VideoSize> ReadSizes(
    int fd, uint32_t fourcc, int width, int height, int* entries_left) {
  std::vector<VideoSize> sizes;
  for (uint32_t i = 0; --*entries_left >= 0; ++i) {
    v4l2_frmsizeenum query{};
    query.index = i;
    query.pixel_format = fourcc;
    if (Ioctl(fd, VIDIOC_ENUM_FRAMESIZES, &query) != 0) break;
    if (query.type == V4L2_FRMSIZE_TYPE_DISCRETE) {
      VideoSize size = FixedSize(query.discrete.width, query.discrete.height);
      if (i > 0 && size.width == sizes.front().width && size.height == sizes.front().height) break;
      size.rates = ReadRates(fd, fourcc, query.discrete.width, query.discrete.height, entries_left);
      sizes.push_back(size);
      continue;
    }
    const v4l2_frmsize_stepwise& range = query.stepwise;
    VideoSize size;
    size.width = {1.0 * range.min_width, 1.0 * range.max_width, 1.0 * range.step_width};
    size.height = {1.0 * range.min_height, 1.0 * range.max_height, 1.0 * range.step_height};
    const bool contained = size.width.Contains(width) && size.height.Contains(height);
    size.rates = ReadRates(fd,
                           fourcc,
                           contained ? static_cast<uint32_t>(width) : range.max_width,
                           contained ? static_cast<uint32_t>(height) : range.max_height,
                           entries_left);
    sizes.push_back(size);
    break;
  }
  return sizes;
}

bool HasRate(const VideoSize& size, int fps) {
  return size.rates.empty() || std::ranges::any_of(size.rates, [fps](const ModeRange& rate) {
           return fps >= rate.lowest * (1.0 - kRateTolerance) &&
                  fps <= rate.highest * (1.0 + kRateTolerance);
         });
}

bool Fits(const VideoFormat& format, const StreamRequest& request) {
  return format.sizes.empty() || std::ranges::any_of(format.sizes, [&](const VideoSize& size) {
           return size.width.Contains(request.width) && size.height.Contains(request.height) &&
                  HasRate(size, request.fps);
         });
}

// Whether its images can be had in the layout that is asked for.
bool Converts(const PixelFormat& format, const StreamRequest& request) {
  return format.kind == PixelFormat::Kind::kDepth || format.bits == 0 ||
         request.color_layout != PixelLayout::kJpeg;
}

std::string RangeText(const ModeRange& range) {
  if (range.lowest == range.highest) return Format("%.6g", range.lowest);
  return Format("%.6g-%.6g", range.lowest, range.highest);
}

}  // namespace

bool ModeRange::Contains(double value) const {
  if (!(value >= lowest && value <= highest)) return false;
  return step <= 0.0 || std::fmod(value - lowest, step) == 0.0;
}

std::vector<VideoFormat> ReadVideoFormats(int fd, uint32_t buffer_type, int width, int height) {
  std::vector<VideoFormat> formats;
  int entries_left = kMostEntries;
  for (uint32_t i = 0; --entries_left >= 0; ++i) {
    v4l2_fmtdesc query{};
    query.index = i;
    query.type = buffer_type;
    if (Ioctl(fd, VIDIOC_ENUM_FMT, &query) != 0) break;
    if (i > 0 && query.pixelformat == formats.front().fourcc) break;
    query.description[sizeof(query.description) - 1] = '\0';
    std::string description;
    for (const unsigned char* c = query.description; *c != '\0'; ++c) {
      if (*c >= ' ' && *c <= '~') description += static_cast<char>(*c);
    }
    formats.push_back({query.pixelformat,
                       description,
                       ReadSizes(fd, query.pixelformat, width, height, &entries_left)});
  }
  return formats;
}

Result<const PixelFormat*> ChooseFormat(const std::vector<VideoFormat>& formats,
                                        const std::string& wanted,
                                        const StreamRequest& request,
                                        const std::string& path) {
  const PixelFormat* best = nullptr;
  for (const VideoFormat& offered : formats) {
    const PixelFormat* format = FindPixelFormat(offered.fourcc);
    if (format == nullptr || (wanted != "auto" && wanted != format->name)) continue;
    if (!Fits(offered, request) || !Converts(*format, request)) continue;
    // Of PixelFormat's list, which is in order of preference.
    if (best == nullptr || format < best) best = format;
  }
  if (best != nullptr) return best;
  return Error{ErrorCode::kInvalidArgument,
               Format("device %s has no %s%s of %dx%d at %d Hz, expected one of: %s",
                      path.c_str(),
                      wanted == "auto" ? "format known here" : wanted.c_str(),
                      request.color_layout == PixelLayout::kJpeg
                          ? " that is JPEG, as color_encoding wants it,"
                          : "",
                      request.width,
                      request.height,
                      request.fps,
                      FormatsText(formats).c_str())};
}

std::string SizeText(const VideoSize& size) {
  return RangeText(size.width) + "x" + RangeText(size.height);
}

std::string RatesText(const VideoSize& size) {
  std::string text;
  for (const ModeRange& rate : size.rates) text += (text.empty() ? "" : ", ") + RangeText(rate);
  return text.empty() ? text : text + " Hz";
}

std::string FormatsText(const std::vector<VideoFormat>& formats) {
  std::string text;
  std::string unknown;
  int num_unknown = 0;
  for (const VideoFormat& format : formats) {
    if (FindPixelFormat(format.fourcc) == nullptr) {
      // Some devices have sixty.
      if (num_unknown++ < kMostUnknown) unknown.append(" ").append(FourccText(format.fourcc));
      continue;
    }
    std::string sizes;
    for (const VideoSize& size : format.sizes) {
      sizes += (sizes.empty() ? "" : ", ") + SizeText(size);
      if (!size.rates.empty()) sizes += " at " + RatesText(size);
    }
    text += (text.empty() ? "" : ", ") + FourccText(format.fourcc);
    if (!sizes.empty()) text += " (" + sizes + ")";
  }
  if (text.empty()) text = "none";
  if (num_unknown > 0) text += "; not known here:" + unknown;
  if (num_unknown > kMostUnknown) text += Format(" and %d more", num_unknown - kMostUnknown);
  return text;
}

}  // namespace vantage
