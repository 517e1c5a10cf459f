#include "drivers/v4l2/v4l2_stream.h"

#include <utility>
#include <vector>

#include "drivers/v4l2/video_mode.h"
#include "drivers/v4l2/video_node.h"

namespace vantage {

Result<std::unique_ptr<V4l2Stream>> V4l2Stream::Open(const std::string& path) {
  Result<FileDescriptor> fd = OpenVideoNode(path);
  if (!fd) return fd.error();
  const Result<VideoCapability> capability = ReadCapability(fd->get(), path);
  if (!capability) return capability.error();
  if (Result<void> captures = CheckCapture(*capability, path); !captures) return captures.error();
  return std::unique_ptr<V4l2Stream>(
      new V4l2Stream(path, std::move(*fd), capability->buffer_type()));
}

V4l2Stream::V4l2Stream(const std::string& path, FileDescriptor fd, uint32_t buffer_type)
    : path_(path), fd_(std::move(fd)), buffer_type_(buffer_type), controls_(fd_.get(), path) {}

Result<void> V4l2Stream::Start(const StreamRequest& request,
                               const std::string& pixel_format,
                               Kind kind) {
  std::vector<VideoFormat> formats =
      ReadVideoFormats(fd_.get(), buffer_type_, request.width, request.height);
  if (kind == Kind::kColor) {
    std::erase_if(formats, [](const VideoFormat& format) {
      const PixelFormat* pixel = FindPixelFormat(format.fourcc);
      return pixel != nullptr && pixel->kind == PixelFormat::Kind::kDepth;
    });
  }
  const Result<const PixelFormat*> pixel = ChooseFormat(formats, pixel_format, request, path_);
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
  format_ = *format;
  rate_hz_ = rate_hz;
  queue_ = std::move(*queue);
  return {};
}

}  // namespace vantage
