#include "drivers/v4l2/frame_converter.h"

#include "common/check.h"
#include "common/format.h"
#include "common/jpeg_decoder.h"

namespace vantage {
namespace {

int64_t PixelBytes(PixelLayout layout) {
  switch (layout) {
    case PixelLayout::kDepth16:
      return 2;
    case PixelLayout::kRgb8:
      return 3;
    case PixelLayout::kGray8:
      return 1;
    case PixelLayout::kJpeg:
      break;
  }
  return 0;
}

bool IsSameInMemory(uint32_t fourcc, PixelLayout layout) {
  return fourcc == V4L2_PIX_FMT_Z16 || fourcc == V4L2_PIX_FMT_Y16 ||
         (fourcc == V4L2_PIX_FMT_RGB24 && layout == PixelLayout::kRgb8) ||
         (fourcc == V4L2_PIX_FMT_GREY && layout == PixelLayout::kGray8);
}

// Without the zeros that some cameras put after it. Empty: it has no beginning or no end.
std::span<const std::byte> TrimJpeg(std::span<const std::byte> jpeg) {
  size_t size = jpeg.size();
  while (size > 0 && jpeg[size - 1] == std::byte{0}) --size;
  const bool whole = size >= 4 && jpeg[0] == std::byte{0xff} && jpeg[1] == std::byte{0xd8} &&
                     jpeg[size - 2] == std::byte{0xff} && jpeg[size - 1] == std::byte{0xd9};
  return whole ? jpeg.first(size) : std::span<const std::byte>();
}

}  // namespace

FrameConverter::FrameConverter(const StreamFormat& format,
                               PixelLayout color_layout,
                               const DisparityModel& disparity)
    : format_(format),
      layout_(format.pixel->kind == PixelFormat::Kind::kDepth ? PixelLayout::kDepth16
                                                              : color_layout),
      table_(DisparityTable(disparity)),
      packed_row_bytes_(PixelBytes(layout_) * format.width),
      as_it_is_(IsSameInMemory(format.pixel->fourcc, layout_)) {
  VANTAGE_CHECK(layout_ != PixelLayout::kJpeg || format.pixel->bits == 0, "no JPEG format");
  const bool in_place =
      layout_ == PixelLayout::kJpeg || (as_it_is_ && format.stride_bytes == packed_row_bytes_);
  if (!in_place) converted_.resize(static_cast<size_t>(packed_row_bytes_ * format.height));
  const bool through_rgb =
      layout_ == PixelLayout::kGray8 &&
      (format.pixel->fourcc == V4L2_PIX_FMT_SGRBG8 || format.pixel->fourcc == V4L2_PIX_FMT_BGR24);
  if (through_rgb)
    rgb_.resize(static_cast<size_t>(3 * format.width) * static_cast<size_t>(format.height));
}

std::string FrameConverter::Convert(std::span<const std::byte> data, RawImage* image) {
  image->layout = layout_;
  image->width = format_.width;
  image->height = format_.height;
  image->stride_bytes = static_cast<int>(packed_row_bytes_);
  if (layout_ == PixelLayout::kJpeg) {
    image->stride_bytes = 0;
    image->data = TrimJpeg(data);
    return image->data.empty()
               ? Format("bad JPEG: %zu bytes without a beginning or an end", data.size())
               : std::string();
  }
  if (format_.pixel->bits == 0) {
    const std::span<const uint8_t> jpeg(reinterpret_cast<const uint8_t*>(data.data()), data.size());
    const JpegPixels kind = layout_ == PixelLayout::kGray8 ? JpegPixels::kGray : JpegPixels::kRgb;
    const Result<void> decoded = DecodeJpeg(jpeg, format_.width, format_.height, kind, &converted_);
    image->data = std::as_bytes(std::span(converted_));
    return decoded ? std::string() : decoded.error().message;
  }
  if (data.size() < static_cast<size_t>(format_.image_bytes)) {
    return Format("a short image of %zu bytes, expected at least %lld",
                  data.size(),
                  static_cast<long long>(format_.image_bytes));
  }
  if (converted_.empty()) {
    image->data = data.first(static_cast<size_t>(format_.image_bytes));
    return {};
  }
  ConvertRows({data.data(), format_.width, format_.height, format_.stride_bytes});
  image->data = std::as_bytes(std::span(converted_));
  return {};
}

void FrameConverter::ConvertRows(const PixelRows& rows) {
  if (as_it_is_) {
    PackRows(rows, packed_row_bytes_, converted_.data());
  } else if (layout_ == PixelLayout::kDepth16) {
    UnpackTenBits(rows, table_, reinterpret_cast<uint16_t*>(converted_.data()));
  } else {
    ConvertColor(rows, converted_.data());
  }
}

void FrameConverter::ConvertColor(const PixelRows& rows, uint8_t* pixels) {
  const bool gray = layout_ == PixelLayout::kGray8;
  uint8_t* rgb = rgb_.empty() ? pixels : rgb_.data();
  switch (format_.pixel->fourcc) {
    case V4L2_PIX_FMT_YUYV:
    case V4L2_PIX_FMT_UYVY: {
      const YuvOrder order =
          format_.pixel->fourcc == V4L2_PIX_FMT_YUYV ? YuvOrder::kYuyv : YuvOrder::kUyvy;
      (gray ? &YuvToGray : &YuvToRgb)(rows, order, format_.yuv, pixels);
      return;
    }
    case V4L2_PIX_FMT_GREY:
      GrayToRgb(rows, pixels);
      return;
    case V4L2_PIX_FMT_RGB24:
      RgbToGray(rows, pixels);
      return;
    case V4L2_PIX_FMT_SGRBG8:
      BayerGrbgToRgb(rows, rgb);
      break;
    case V4L2_PIX_FMT_BGR24:
      BgrToRgb(rows, rgb);
      break;
    default:
      VANTAGE_CHECK(false, format_.pixel->name);
  }
  if (!gray) return;
  RgbToGray({reinterpret_cast<const std::byte*>(rgb), rows.width, rows.height, 3L * rows.width},
            pixels);
}

}  // namespace vantage
