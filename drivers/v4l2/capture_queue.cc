#include "drivers/v4l2/capture_queue.h"

#include <poll.h>
#include <sys/mman.h>

#include <algorithm>
#include <cerrno>

#include "common/format.h"
#include "drivers/v4l2/stream_format.h"
#include "drivers/v4l2/v4l2_ioctl.h"

namespace vantage {
namespace {

using std::chrono::steady_clock;

constexpr uint32_t kNumBuffers = 4;
constexpr uint32_t kFewestBuffers = 2;              // one with the driver, one with the program
constexpr int64_t kLatestStamp = int64_t{1} << 40;  // s

// A buffer as the ioctls have it, for single- and multi-planar devices alike.
struct BufferArgument {
  BufferArgument(uint32_t buffer_type, uint32_t index) {
    buffer.type = buffer_type;
    buffer.memory = V4L2_MEMORY_MMAP;
    buffer.index = index;
    if (buffer_type != V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE) return;
    is_planar = true;
    buffer.m.planes = planes;
    buffer.length = VIDEO_MAX_PLANES;
  }
  BufferArgument(const BufferArgument&) = delete;
  BufferArgument& operator=(const BufferArgument&) = delete;

  [[nodiscard]] uint32_t length() const { return is_planar ? planes[0].length : buffer.length; }
  [[nodiscard]] uint32_t offset() const {
    return is_planar ? planes[0].m.mem_offset : buffer.m.offset;
  }
  // Where the image begins and ends.
  [[nodiscard]] uint32_t begin() const { return is_planar ? planes[0].data_offset : 0; }
  [[nodiscard]] uint32_t end() const { return is_planar ? planes[0].bytesused : buffer.bytesused; }

  v4l2_buffer buffer{};
  v4l2_plane planes[VIDEO_MAX_PLANES]{};
  bool is_planar = false;
};

bool IsMonotonic(const v4l2_buffer& buffer) {
  return (buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
}

bool MeansGone(int error) {
  return error == ENODEV || error == ENXIO || error == EBADF || error == EPIPE;
}

// Empty: nothing is wrong with it.
std::string FaultOf(const BufferArgument& argument, size_t length) {
  const v4l2_buffer& buffer = argument.buffer;
  if ((buffer.flags & V4L2_BUF_FLAG_ERROR) != 0) return "the driver marked the image as damaged";
  if (argument.end() > length || argument.begin() > argument.end()) {
    return Format("an image from byte %u to byte %u of a buffer of %zu",
                  argument.begin(),
                  argument.end(),
                  length);
  }
  if (buffer.timestamp.tv_sec < 0 || buffer.timestamp.tv_sec > kLatestStamp ||
      buffer.timestamp.tv_usec < 0 || buffer.timestamp.tv_usec >= 1'000'000) {
    return Format("an image with the time stamp %lld s %lld us",
                  static_cast<long long>(buffer.timestamp.tv_sec),
                  static_cast<long long>(buffer.timestamp.tv_usec));
  }
  return {};
}

}  // namespace

Result<std::unique_ptr<CaptureQueue>> CaptureQueue::Create(int fd,
                                                           uint32_t buffer_type,
                                                           int64_t image_bytes,
                                                           const std::string& path) {
  std::unique_ptr<CaptureQueue> queue(new CaptureQueue(fd, buffer_type, path));
  v4l2_requestbuffers request{};
  request.count = kNumBuffers;
  request.type = buffer_type;
  request.memory = V4L2_MEMORY_MMAP;
  if (const int error = Ioctl(fd, VIDIOC_REQBUFS, &request); error != 0) {
    return SystemError(path, "gives no buffers", error);
  }
  if (request.count < kFewestBuffers || request.count > VIDEO_MAX_FRAME) {
    return Error{ErrorCode::kUnavailable,
                 Format("device %s gives %u buffers, expected %u to %d",
                        path.c_str(),
                        request.count,
                        kFewestBuffers,
                        VIDEO_MAX_FRAME)};
  }
  for (uint32_t i = 0; i < request.count; ++i) {
    if (Result<void> mapped = queue->Map(i, image_bytes); !mapped) return mapped.error();
  }
  return queue;
}

Result<void> CaptureQueue::Map(uint32_t index, int64_t image_bytes) {
  BufferArgument argument(buffer_type_, index);
  if (const int error = Ioctl(fd_, VIDIOC_QUERYBUF, &argument.buffer); error != 0) {
    return SystemError(path_, "does not describe its buffers", error);
  }
  const size_t length = argument.length();
  if (length == 0 || argument.length() < image_bytes || argument.length() > kLargestImage) {
    return Error{ErrorCode::kInvalidArgument,
                 Format("device %s has buffers of %zu bytes, expected %lld to %lld",
                        path_.c_str(),
                        length,
                        static_cast<long long>(std::max<int64_t>(image_bytes, 1)),
                        static_cast<long long>(kLargestImage))};
  }
  void* memory = mmap(nullptr, length, PROT_READ | PROT_WRITE, MAP_SHARED, fd_, argument.offset());
  if (memory == MAP_FAILED) return SystemError(path_, "can't map its buffers", errno);
  has_stamps_ = IsMonotonic(argument.buffer);
  memory_.emplace_back(static_cast<std::byte*>(memory), length);
  return {};
}

CaptureQueue::~CaptureQueue() {
  int type = static_cast<int>(buffer_type_);
  Ioctl(fd_, VIDIOC_STREAMOFF, &type);
  for (const std::span<std::byte>& memory : memory_) munmap(memory.data(), memory.size());
  v4l2_requestbuffers request{};
  request.type = buffer_type_;
  request.memory = V4L2_MEMORY_MMAP;
  Ioctl(fd_, VIDIOC_REQBUFS, &request);
}

Result<void> CaptureQueue::Start() {
  for (uint32_t i = 0; i < memory_.size(); ++i) {
    if (const int error = Give(i); error != 0) {
      return SystemError(path_, "takes no buffer", error);
    }
  }
  int type = static_cast<int>(buffer_type_);
  if (const int error = Ioctl(fd_, VIDIOC_STREAMON, &type); error != 0) {
    return SystemError(path_, "does not start to stream", error);
  }
  return {};
}

int CaptureQueue::Give(uint32_t index) {
  BufferArgument argument(buffer_type_, index);
  return Ioctl(fd_, VIDIOC_QBUF, &argument.buffer);
}

CaptureQueue::Outcome CaptureQueue::Dequeue(std::chrono::milliseconds timeout,
                                            CapturedBuffer* captured) {
  *captured = {};
  if (taken_ >= 0) {
    const int error = Give(static_cast<uint32_t>(taken_));
    if (MeansGone(error)) return Outcome::kGone;
    taken_ = -1;
    if (error != 0) return Outcome::kError;
  }
  const auto deadline = steady_clock::now() + timeout;
  for (auto left = timeout; left.count() >= 0;
       left = std::chrono::ceil<std::chrono::milliseconds>(deadline - steady_clock::now())) {
    pollfd ready{fd_, POLLIN, 0};
    const int count = poll(&ready, 1, static_cast<int>(left.count()));
    if (count < 0 && errno != EINTR) return Outcome::kGone;
    if (count == 0) return Outcome::kTimeout;
    if (count < 0) continue;
    if ((ready.revents & (POLLHUP | POLLNVAL)) != 0) return Outcome::kGone;
    const Outcome outcome = Take(captured);
    // Another wake-up than for an image.
    if (outcome == Outcome::kTimeout && (ready.revents & POLLERR) == 0) continue;
    return outcome == Outcome::kTimeout ? Outcome::kGone : outcome;
  }
  return Outcome::kTimeout;
}

// kTimeout: there is none.
CaptureQueue::Outcome CaptureQueue::Take(CapturedBuffer* captured) {
  BufferArgument argument(buffer_type_, 0);
  const int error = Ioctl(fd_, VIDIOC_DQBUF, &argument.buffer);
  if (error == EAGAIN) return Outcome::kTimeout;
  if (error == EIO) return Outcome::kError;
  if (error != 0) return Outcome::kGone;
  if (argument.buffer.index >= memory_.size()) return Outcome::kError;
  taken_ = argument.buffer.index;
  const std::span<const std::byte> memory = memory_[argument.buffer.index];
  captured->index = argument.buffer.sequence;
  captured->fault = FaultOf(argument, memory.size());
  if (!captured->fault.empty()) return Outcome::kFilled;
  captured->data = memory.subspan(argument.begin(), argument.end() - argument.begin());
  const timeval& stamp = argument.buffer.timestamp;
  captured->time_us = IsMonotonic(argument.buffer)
                          ? int64_t{stamp.tv_sec} * 1'000'000 + stamp.tv_usec
                          : std::chrono::duration_cast<std::chrono::microseconds>(
                                steady_clock::now().time_since_epoch())
                                .count();
  return Outcome::kFilled;
}

}  // namespace vantage
