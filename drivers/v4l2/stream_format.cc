#include "drivers/v4l2/stream_format.h"

#include "common/format.h"
#include "drivers/v4l2/v4l2_ioctl.h"

namespace vantage {
namespace {

// What single- and multi-planar formats tell alike.
struct Answer {
  uint32_t width = 0;
  uint32_t height = 0;
  uint32_t fourcc = 0;
  uint32_t field = 0;
  uint32_t num_planes = 1;
  uint32_t stride = 0;
  uint32_t size = 0;
  uint32_t colorspace = 0;
  uint32_t ycbcr_enc = 0;
  uint32_t quantization = 0;
};

bool IsMultiPlanar(uint32_t buffer_type) {
  return buffer_type == V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE;
}

Answer AnswerOf(const v4l2_format& format) {
  if (IsMultiPlanar(format.type)) {
    const v4l2_pix_format_mplane& pix = format.fmt.pix_mp;
    return {pix.width,
            pix.height,
            pix.pixelformat,
            pix.field,
            pix.num_planes,
            pix.plane_fmt[0].bytesperline,
            pix.plane_fmt[0].sizeimage,
            pix.colorspace,
            pix.ycbcr_enc,
            pix.quantization};
  }
  const v4l2_pix_format& pix = format.fmt.pix;
  return {pix.width,
          pix.height,
          pix.pixelformat,
          pix.field,
          1,
          pix.bytesperline,
          pix.sizeimage,
          pix.colorspace,
          pix.ycbcr_enc,
          pix.quantization};
}

// The kernel's rules for what a driver leaves open.
YuvEncoding YuvOf(const Answer& answer) {
  uint32_t encoding = answer.ycbcr_enc;
  if (encoding == V4L2_YCBCR_ENC_DEFAULT) encoding = V4L2_MAP_YCBCR_ENC_DEFAULT(answer.colorspace);
  uint32_t quantization = answer.quantization;
  if (quantization == V4L2_QUANTIZATION_DEFAULT) {
    quantization = V4L2_MAP_QUANTIZATION_DEFAULT(false, answer.colorspace, encoding);
  }
  return {encoding == V4L2_YCBCR_ENC_709 || encoding == V4L2_YCBCR_ENC_XV709,
          quantization == V4L2_QUANTIZATION_FULL_RANGE};
}

Error Refuse(const std::string& path, const std::string& reason) {
  return {ErrorCode::kInvalidArgument, "device " + path + " " + reason};
}

Result<void> CheckLayout(const Answer& answer, const std::string& path, StreamFormat* format) {
  if (format->pixel->bits == 0) {
    if (answer.size > 0 && answer.size <= kLargestImage) return {};
    return Refuse(path,
                  Format("says that an image takes %u bytes, expected 1 to %lld",
                         answer.size,
                         static_cast<long long>(kLargestImage)));
  }
  int64_t row = RowBytes(*format->pixel, format->width);
  // Two pixels of 4:2:2 share their color.
  const bool pairs =
      format->pixel->fourcc == V4L2_PIX_FMT_YUYV || format->pixel->fourcc == V4L2_PIX_FMT_UYVY;
  if (pairs && format->width % 2 != 0) row += 2;
  // Some drivers leave it at 0 where there is nothing to say.
  format->stride_bytes = answer.stride == 0 ? row : answer.stride;
  format->image_bytes = format->stride_bytes * (format->height - 1) + row;
  if (format->stride_bytes < row) {
    return Refuse(path,
                  Format("says that its rows are %u bytes apart, expected at least %lld for %d px",
                         answer.stride,
                         static_cast<long long>(row),
                         format->width));
  }
  if (answer.size < format->image_bytes || answer.size > kLargestImage) {
    return Refuse(path,
                  Format("says that an image takes %u bytes, expected %lld to %lld",
                         answer.size,
                         static_cast<long long>(format->image_bytes),
                         static_cast<long long>(kLargestImage)));
  }
  return {};
}

v4l2_format Question(uint32_t buffer_type, const PixelFormat& pixel, const StreamRequest& request) {
  v4l2_format format{};
  format.type = buffer_type;
  if (IsMultiPlanar(buffer_type)) {
    v4l2_pix_format_mplane& pix = format.fmt.pix_mp;
    pix.width = static_cast<uint32_t>(request.width);
    pix.height = static_cast<uint32_t>(request.height);
    pix.pixelformat = pixel.fourcc;
    pix.field = V4L2_FIELD_NONE;
    pix.num_planes = 1;
  } else {
    v4l2_pix_format& pix = format.fmt.pix;
    pix.width = static_cast<uint32_t>(request.width);
    pix.height = static_cast<uint32_t>(request.height);
    pix.pixelformat = pixel.fourcc;
    pix.field = V4L2_FIELD_NONE;
  }
  return format;
}

}  // namespace

Result<StreamFormat> CheckFormat(const v4l2_format& answer_format,
                                 const PixelFormat& pixel,
                                 const StreamRequest& request,
                                 const std::string& path) {
  const Answer answer = AnswerOf(answer_format);
  if (answer.fourcc != pixel.fourcc || answer.width != static_cast<uint32_t>(request.width) ||
      answer.height != static_cast<uint32_t>(request.height)) {
    return Refuse(path,
                  Format("gives %s of %ux%u px when asked for %s of %dx%d px",
                         FourccText(answer.fourcc).c_str(),
                         answer.width,
                         answer.height,
                         pixel.name,
                         request.width,
                         request.height));
  }
  if (answer.num_planes != 1) {
    return Refuse(path, Format("gives images in %u planes, expected 1", answer.num_planes));
  }
  if (answer.field != V4L2_FIELD_ANY && answer.field != V4L2_FIELD_NONE &&
      answer.field != V4L2_FIELD_INTERLACED) {
    return Refuse(path,
                  Format("gives single fields of interlaced images (field order %u), expected "
                         "whole images",
                         answer.field));
  }
  StreamFormat format;
  format.pixel = &pixel;
  format.width = request.width;
  format.height = request.height;
  format.yuv = YuvOf(answer);
  if (pixel.fourcc == V4L2_PIX_FMT_SGRBG8 && (format.width < 2 || format.height < 2)) {
    return Refuse(
        path,
        Format("gives GRBG of %d x %d px, expected at least 2 x 2", format.width, format.height));
  }
  if (Result<void> sane = CheckLayout(answer, path, &format); !sane) return sane.error();
  return format;
}

Result<StreamFormat> SetFormat(int fd,
                               uint32_t buffer_type,
                               const PixelFormat& pixel,
                               const StreamRequest& request,
                               const std::string& path) {
  v4l2_format format = Question(buffer_type, pixel, request);
  if (const int error = Ioctl(fd, VIDIOC_S_FMT, &format); error != 0) {
    return SystemError(path, Format("refuses %s", pixel.name), error);
  }
  return CheckFormat(format, pixel, request, path);
}

Result<void> ConfirmFormat(int fd,
                           uint32_t buffer_type,
                           const StreamFormat& agreed,
                           const StreamRequest& request,
                           const std::string& path) {
  v4l2_format format{};
  format.type = buffer_type;
  if (const int error = Ioctl(fd, VIDIOC_G_FMT, &format); error != 0) {
    return SystemError(path, "does not tell its format", error);
  }
  const Result<StreamFormat> now = CheckFormat(format, *agreed.pixel, request, path);
  if (!now) return now.error();
  if (*now == agreed) return {};
  return Refuse(path, "was set to rows of another length by another program");
}

double SetRate(int fd, uint32_t buffer_type, int fps) {
  v4l2_streamparm parameters{};
  parameters.type = buffer_type;
  parameters.parm.capture.timeperframe = {1, static_cast<uint32_t>(fps)};
  if (Ioctl(fd, VIDIOC_S_PARM, &parameters) != 0) return 0.0;
  const v4l2_fract& interval = parameters.parm.capture.timeperframe;
  if (interval.numerator == 0) return 0.0;
  return static_cast<double>(interval.denominator) / interval.numerator;
}

}  // namespace vantage
