#include "tests/drivers/v4l2_shim/format_requests.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "tests/drivers/v4l2_shim/fixed_text.h"
#include "tests/drivers/v4l2_shim/frame_source.h"

namespace vantage::v4l2_shim {
namespace {

// The kernel's words.
const char* TitleOf(uint32_t fourcc) {
  switch (fourcc) {
    case V4L2_PIX_FMT_YUYV:
      return "YUYV 4:2:2";
    case V4L2_PIX_FMT_UYVY:
      return "UYVY 4:2:2";
    case V4L2_PIX_FMT_GREY:
      return "8-bit Greyscale";
    case V4L2_PIX_FMT_SGRBG8:
      return "8-bit Bayer GRGR/BGBG";
    case V4L2_PIX_FMT_Y16:
      return "16-bit Greyscale";
    case V4L2_PIX_FMT_Z16:
      return "16-bit Depth";
    case V4L2_PIX_FMT_Y10BPACK:
      return "10-bit Greyscale (Packed)";
    case V4L2_PIX_FMT_MJPEG:
      return "Motion-JPEG";
    default:
      return "Emulated";
  }
}

// Each once, in the description's order.
std::vector<uint32_t> FourCcs(const Device& device) {
  std::vector<uint32_t> codes;
  for (const FormatMode& mode : device.formats) {
    if (std::ranges::find(codes, mode.fourcc) == codes.end()) codes.push_back(mode.fourcc);
  }
  return codes;
}

std::vector<const FormatMode*> ModesOf(const Device& device, uint32_t fourcc) {
  std::vector<const FormatMode*> modes;
  for (const FormatMode& mode : device.formats) {
    if (mode.fourcc == fourcc) modes.push_back(&mode);
  }
  return modes;
}

bool HasSize(const FormatMode& mode, uint32_t width, uint32_t height) {
  if (!mode.stepwise) return mode.width == width && mode.height == height;
  return width >= mode.width && width <= mode.max_width && height >= mode.height &&
         height <= mode.max_height && (width - mode.width) % mode.step == 0 &&
         (height - mode.height) % mode.step == 0;
}

const FormatMode* FindMode(const Device& device, uint32_t fourcc, uint32_t width, uint32_t height) {
  for (const FormatMode* mode : ModesOf(device, fourcc)) {
    if (HasSize(*mode, width, height)) return mode;
  }
  return nullptr;
}

// The index into `count` things, where an endless enumeration begins again; -1: past the end.
int64_t Place(const Device& device, uint32_t index, size_t count) {
  if (count == 0) return -1;
  if (index < count) return index;
  return device.Fault("endless", 0) != nullptr ? static_cast<int64_t>(index % count) : -1;
}

double Hertz(const Fraction& rate) {
  return rate.denominator == 0 ? 0.0 : double{1.0} * rate.numerator / rate.denominator;
}

void FillPixelFormat(const DeviceState& state, const Device& device, v4l2_pix_format* pix) {
  *pix = v4l2_pix_format{};
  pix->width = device.Answer("width", state.width);
  pix->height = device.Answer("height", state.height);
  pix->pixelformat = device.Answer("pixelformat", state.fourcc);
  pix->field = V4L2_FIELD_NONE;
  pix->bytesperline =
      device.Answer("bytesperline", BytesPerLine(device, state.fourcc, state.width));
  pix->sizeimage =
      device.Answer("sizeimage", SizeImage(device, state.fourcc, state.width, state.height));
  pix->colorspace = V4L2_COLORSPACE_SRGB;
  pix->priv = V4L2_PIX_FMT_PRIV_MAGIC;
}

uint32_t Nearest(uint32_t value, uint32_t lowest, uint32_t highest, uint32_t step) {
  const uint32_t clamped = std::clamp(value, lowest, highest);
  return lowest + (clamped - lowest) / step * step;
}

}  // namespace

int EnumerateFormats(const Device& device, v4l2_fmtdesc* format) {
  if (format->type != V4L2_BUF_TYPE_VIDEO_CAPTURE) return EINVAL;
  const std::vector<uint32_t> codes = FourCcs(device);
  const int64_t place = Place(device, format->index, codes.size());
  if (place < 0) return EINVAL;
  const uint32_t index = format->index;
  *format = v4l2_fmtdesc{};
  format->index = index;
  format->type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  format->pixelformat = codes[static_cast<size_t>(place)];
  if (format->pixelformat == V4L2_PIX_FMT_MJPEG) format->flags = V4L2_FMT_FLAG_COMPRESSED;
  SetText(device, TitleOf(format->pixelformat), format->description);
  return 0;
}

int EnumerateSizes(const Device& device, v4l2_frmsizeenum* size) {
  const std::vector<const FormatMode*> modes = ModesOf(device, size->pixel_format);
  const int64_t place = Place(device, size->index, modes.size());
  if (place < 0) return EINVAL;
  const FormatMode& mode = *modes[static_cast<size_t>(place)];
  const uint32_t index = size->index;
  *size = v4l2_frmsizeenum{};
  size->index = index;
  size->pixel_format = mode.fourcc;
  if (mode.stepwise) {
    size->type = V4L2_FRMSIZE_TYPE_STEPWISE;
    size->stepwise = {
        mode.width, mode.max_width, mode.step, mode.height, mode.max_height, mode.step};
  } else {
    size->type = V4L2_FRMSIZE_TYPE_DISCRETE;
    size->discrete = {mode.width, mode.height};
  }
  return 0;
}

int EnumerateIntervals(const Device& device, v4l2_frmivalenum* interval) {
  const FormatMode* mode =
      FindMode(device, interval->pixel_format, interval->width, interval->height);
  if (mode == nullptr) return EINVAL;
  const int64_t place = Place(device, interval->index, mode->rates.size());
  if (place < 0) return EINVAL;
  const Fraction& rate = mode->rates[static_cast<size_t>(place)];
  interval->type = V4L2_FRMIVAL_TYPE_DISCRETE;
  interval->discrete = {rate.denominator, rate.numerator};
  interval->reserved[0] = interval->reserved[1] = 0;
  return 0;
}

int EnumerateInput(const Device& device, v4l2_input* input) {
  if (input->index != 0) return EINVAL;
  *input = v4l2_input{};
  SetText(device, "Camera 1", input->name);
  input->type = V4L2_INPUT_TYPE_CAMERA;
  return 0;
}

int GetFormat(const DeviceState& state, const Device& device, v4l2_format* format) {
  if (format->type != V4L2_BUF_TYPE_VIDEO_CAPTURE) return EINVAL;
  FillPixelFormat(state, device, &format->fmt.pix);
  return 0;
}

int ChooseFormat(const Device& device, v4l2_format* format, DeviceState* state) {
  if (format->type != V4L2_BUF_TYPE_VIDEO_CAPTURE || device.formats.empty()) return EINVAL;
  const v4l2_pix_format& wanted = format->fmt.pix;
  std::vector<const FormatMode*> modes = ModesOf(device, wanted.pixelformat);
  if (modes.empty()) modes = ModesOf(device, device.formats.front().fourcc);
  int64_t least = INT64_MAX;
  for (const FormatMode* mode : modes) {
    const uint32_t width = mode->stepwise
                               ? Nearest(wanted.width, mode->width, mode->max_width, mode->step)
                               : mode->width;
    const uint32_t height = mode->stepwise
                                ? Nearest(wanted.height, mode->height, mode->max_height, mode->step)
                                : mode->height;
    const int64_t distance = std::abs(int64_t{width} - int64_t{wanted.width}) +
                             std::abs(int64_t{height} - int64_t{wanted.height});
    if (distance >= least) continue;
    least = distance;
    state->fourcc = mode->fourcc;
    state->width = width;
    state->height = height;
  }
  state->rate = NearestRate(device, *state, {});
  FillPixelFormat(*state, device, &format->fmt.pix);
  return 0;
}

// The first for one that is none.
Fraction NearestRate(const Device& device, const DeviceState& state, Fraction wanted) {
  const FormatMode* mode = FindMode(device, state.fourcc, state.width, state.height);
  if (mode == nullptr || mode->rates.empty()) return state.rate;
  if (wanted.numerator == 0 || wanted.denominator == 0) return mode->rates.front();
  return *std::ranges::min_element(mode->rates, {}, [&wanted](const Fraction& rate) {
    return std::abs(Hertz(rate) - Hertz(wanted));
  });
}

}  // namespace vantage::v4l2_shim
