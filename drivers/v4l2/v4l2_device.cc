#include "drivers/v4l2/v4l2_device.h"

#include <chrono>
#include <cmath>
#include <utility>

#include "common/format.h"
#include "drivers/v4l2/stream_format.h"
#include "drivers/v4l2/video_mode.h"

namespace vantage {
namespace {

constexpr int kMostErrors = 3;  // one after the other, before the device counts as broken

int64_t MonotonicUs() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

void AddNote(const std::string& sentence, StreamDetails* details) {
  details->note += (details->note.empty() ? "" : "; ") + sentence;
}

}  // namespace

Result<std::unique_ptr<CameraDevice>> V4l2Device::Open(const std::string& path,
                                                       const std::string& serial,
                                                       const V4l2Options& options) {
  Result<FileDescriptor> fd = OpenVideoNode(path);
  if (!fd) return fd.error();
  const Result<VideoCapability> capability = ReadCapability(fd->get(), path);
  if (!capability) return capability.error();
  if (Result<void> captures = CheckCapture(*capability, path); !captures) return captures.error();
  return std::unique_ptr<CameraDevice>(
      new V4l2Device(path, serial, options, std::move(*fd), capability->buffer_type()));
}

V4l2Device::V4l2Device(const std::string& path,
                       const std::string& serial,
                       const V4l2Options& options,
                       FileDescriptor fd,
                       uint32_t buffer_type)
    : path_(path),
      serial_(serial),
      options_(options),
      fd_(std::move(fd)),
      buffer_type_(buffer_type),
      controls_(fd_.get(), path) {}

Result<StreamDetails> V4l2Device::Start(const StreamRequest& request) {
  const std::vector<VideoFormat> formats =
      ReadVideoFormats(fd_.get(), buffer_type_, request.width, request.height);
  const Result<const PixelFormat*> pixel =
      ChooseFormat(formats, options_.pixel_format, request, path_);
  if (!pixel) return pixel.error();
  const Result<StreamFormat> format = SetFormat(fd_.get(), buffer_type_, **pixel, request, path_);
  if (!format) return format.error();
  const double rate_hz = SetRate(fd_.get(), buffer_type_, request.fps);
  Result<std::unique_ptr<CaptureQueue>> queue =
      CaptureQueue::Create(fd_.get(), buffer_type_, format->image_bytes, path_);
  if (!queue) return queue.error();
  // Until there were buffers another program could set another.
  const Result<void> same = ConfirmFormat(fd_.get(), buffer_type_, *format, request, path_);
  if (!same) return same.error();
  if (Result<void> started = (*queue)->Start(); !started) return started.error();
  queue_ = std::move(*queue);
  converter_.emplace(*format, request.color_layout, options_.disparity);
  return Details(*format, request, rate_hz);
}

StreamDetails V4l2Device::Details(const StreamFormat& format,
                                  const StreamRequest& request,
                                  double rate_hz) const {
  StreamDetails details;
  details.width = format.width;
  details.height = format.height;
  details.has_depth = format.pixel->kind == PixelFormat::Kind::kDepth;
  details.has_color = !details.has_depth;
  const bool is_disparity = format.pixel->fourcc == V4L2_PIX_FMT_Y10BPACK;
  details.depth_unit_um = is_disparity ? 1000 : options_.depth_unit_um;
  details.clock_modulus_us = 0;
  if (rate_hz != 0.0 && std::abs(rate_hz - request.fps) > 0.01 * request.fps) {
    AddNote(Format("it runs at %.4g Hz instead of %d", rate_hz, request.fps), &details);
  }
  if (!queue_->is_monotonic()) {
    AddNote(
        "its driver does not stamp images with the monotonic clock: they have their time of "
        "arrival",
        &details);
  }
  if (request.color && details.has_depth) {
    AddNote("it has no color beside its depth", &details);
  }
  return details;
}

CameraDevice::ReadResult V4l2Device::Read(std::chrono::milliseconds timeout, RawFrame* frame) {
  *frame = {};
  CapturedBuffer captured;
  const CaptureQueue::Outcome outcome = queue_->Dequeue(timeout, &captured);
  switch (outcome) {
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
  image.device_time_us = captured.is_monotonic ? captured.time_us : MonotonicUs();
  (image.layout == PixelLayout::kDepth16 ? frame->depth : frame->color) = image;
  return ReadResult::kFrame;
}

}  // namespace vantage
