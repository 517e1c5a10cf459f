#include "drivers/v4l2/v4l2_device.h"

#include <cmath>
#include <utility>

#include "common/format.h"

namespace vantage {
namespace {

constexpr int kMostErrors = 3;  // one after the other, before the device counts as broken

void AddNote(const std::string& sentence, StreamDetails* details) {
  details->note += (details->note.empty() ? "" : "; ") + sentence;
}

}  // namespace

Result<std::unique_ptr<CameraDevice>> V4l2Device::Open(const std::string& path,
                                                       const std::string& serial,
                                                       const std::vector<std::string>& color_paths,
                                                       const V4l2Options& options,
                                                       const std::function<void()>& on_start) {
  if (Result<void> valid = options.disparity.Validate(); !valid) return valid.error();
  Result<std::unique_ptr<V4l2Stream>> stream = V4l2Stream::Open(path);
  if (!stream) return stream.error();
  return std::unique_ptr<CameraDevice>(
      new V4l2Device(path, serial, color_paths, options, on_start, std::move(*stream)));
}

Result<StreamDetails> V4l2Device::Start(const StreamRequest& request) {
  const Result<void> started =
      stream_->Start(request, options_.pixel_format, V4l2Stream::Kind::kAny);
  if (!started) return started.error();
  converter_.emplace(stream_->format(), request.color_layout, options_.disparity);
  if (options_.color_device) {
    if (Result<void> color = StartColor(request); !color) return color.error();
  }
  on_start_();
  return Details(request);
}

Result<void> V4l2Device::StartColor(const StreamRequest& request) {
  if (stream_->format().pixel->kind != PixelFormat::Kind::kDepth) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("device %s gives %s, expected depth beside the color of color_device %s",
                        path_.c_str(),
                        stream_->format().pixel->name,
                        options_.color_device->Text().c_str())};
  }
  std::string refusals;
  for (const std::string& path : color_paths_) {
    Result<std::unique_ptr<PairedColor>> color = PairedColor::Start(path, request);
    if (color) {
      color_ = std::move(*color);
      return {};
    }
    refusals += (refusals.empty() ? "" : "; ") + color.error().message;
  }
  if (refusals.empty()) refusals = "no other device matches it";
  return Error{ErrorCode::kUnavailable,
               Format("device %s lacks the color of color_device %s: %s",
                      path_.c_str(),
                      options_.color_device->Text().c_str(),
                      refusals.c_str())};
}

StreamDetails V4l2Device::Details(const StreamRequest& request) const {
  const StreamFormat& format = stream_->format();
  StreamDetails details;
  details.width = format.width;
  details.height = format.height;
  details.has_depth = format.pixel->kind == PixelFormat::Kind::kDepth;
  details.has_color = !details.has_depth || color_ != nullptr;
  const bool is_disparity = format.pixel->fourcc == V4L2_PIX_FMT_Y10BPACK;
  details.depth_unit_um = is_disparity ? 1000 : options_.depth_unit_um;
  details.clock_modulus_us = 0;
  const double rate_hz = stream_->rate_hz();
  if (rate_hz != 0.0 && std::abs(rate_hz - request.fps) > 0.01 * request.fps) {
    AddNote(Format("it runs at %.4g Hz instead of %d", rate_hz, request.fps), &details);
  }
  if (!stream_->has_stamps() || (color_ != nullptr && !color_->has_stamps())) {
    AddNote(
        "its driver does not stamp images with the monotonic clock: they have their time of "
        "arrival",
        &details);
  }
  if (request.color && !details.has_color) {
    AddNote("it has no color beside its depth, and no color_device is named", &details);
  }
  return details;
}

CameraDevice::ReadResult V4l2Device::Read(std::chrono::milliseconds timeout, RawFrame* frame) {
  *frame = {};
  CapturedBuffer captured;
  switch (stream_->Read(timeout, &captured)) {
    case CaptureQueue::Outcome::kTimeout:
      return ReadResult::kTimeout;
    case CaptureQueue::Outcome::kGone:
      return ReadResult::kGone;
    case CaptureQueue::Outcome::kError:
      frame->fault = "the driver failed to deliver an image";
      return ++num_errors_ > kMostErrors ? ReadResult::kGone : ReadResult::kBad;
    case CaptureQueue::Outcome::kFilled:
      break;
  }
  num_errors_ = 0;
  frame->index = captured.index;
  RawImage image;
  frame->fault = captured.fault;
  if (frame->fault.empty()) frame->fault = converter_->Convert(captured.data, &image);
  if (!frame->fault.empty()) return ReadResult::kBad;
  image.device_time_us = captured.time_us;
  (image.layout == PixelLayout::kDepth16 ? frame->depth : frame->color) = image;
  if (color_ != nullptr) {
    frame->color = color_->Find(captured.time_us);
    if (color_->is_gone()) return ReadResult::kGone;
  }
  return ReadResult::kFrame;
}

template <class Set>
Result<void> V4l2Device::SetOnEither(const Set& set) {
  const Result<void> done = set(stream_->controls());
  const bool lacks = !done && done.error().code == ErrorCode::kNotFound;
  return lacks && color_ != nullptr ? set(color_->controls()) : done;
}

Result<void> V4l2Device::SetExposure(int exposure_us) {
  return SetOnEither([&](V4l2Controls& controls) { return controls.SetExposure(exposure_us); });
}

Result<void> V4l2Device::SetGain(int gain) {
  return SetOnEither([&](V4l2Controls& controls) { return controls.SetGain(gain); });
}

Result<void> V4l2Device::SetControl(const std::string& name, int64_t value) {
  return SetOnEither([&](V4l2Controls& controls) { return controls.Set(name, value); });
}

}  // namespace vantage
