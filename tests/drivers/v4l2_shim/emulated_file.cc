#include "tests/drivers/v4l2_shim/emulated_file.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <ctime>
#include <utility>

#include "tests/drivers/v4l2_shim/control_requests.h"
#include "tests/drivers/v4l2_shim/fixed_text.h"
#include "tests/drivers/v4l2_shim/format_requests.h"
#include "tests/drivers/v4l2_shim/frame_source.h"

namespace vantage::v4l2_shim {
namespace {

constexpr int64_t kSecond = 1'000'000'000;  // ns
constexpr uint32_t kMostBuffers = VIDEO_MAX_FRAME;
constexpr int64_t kPage = 4096;  // bytes

int64_t NowNs() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * kSecond + now.tv_nsec;
}

int64_t InPages(uint32_t bytes) { return (int64_t{bytes} + kPage - 1) / kPage * kPage; }

bool IsCapture(uint32_t type) { return type == V4L2_BUF_TYPE_VIDEO_CAPTURE; }

}  // namespace

EmulatedFile::EmulatedFile(std::filesystem::path root, const Device& device)
    : root_(std::move(root)), number_(device.number), serial_(device.serial) {
  const std::filesystem::path file =
      root_ / "state" / ("video" + std::to_string(number_) + ".owner");
  owner_file_ = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
}

EmulatedFile::~EmulatedFile() { close(owner_file_); }

bool EmulatedFile::IsFree() const {
  if (is_owner_) return true;
  if (flock(owner_file_, LOCK_EX | LOCK_NB) != 0) return false;
  flock(owner_file_, LOCK_UN);
  return true;
}

bool EmulatedFile::TakeOwnership() {
  is_owner_ = is_owner_ || flock(owner_file_, LOCK_EX | LOCK_NB) == 0;
  return is_owner_;
}

void EmulatedFile::GiveUpOwnership() {
  if (std::exchange(is_owner_, false)) flock(owner_file_, LOCK_UN);
}

int EmulatedFile::Ioctl(const Device& device, int fd, unsigned long request, void* argument) {
  queue_.Advance(device, NowNs());
  if (request == VIDIOC_QUERYCAP) {
    return QueryCapability(device, static_cast<v4l2_capability*>(argument));
  }
  int error = ControlIoctl(root_, device, request, argument);
  if (device.kind != Device::Kind::kCapture) return error;
  if (error == ENOTTY) error = FormatIoctl(device, request, argument);
  if (error == ENOTTY) error = BufferIoctl(device, request, argument);
  Arm(fd);
  return error;
}

int EmulatedFile::QueryCapability(const Device& device, v4l2_capability* capability) const {
  *capability = v4l2_capability{};
  SetText(device, device.driver, capability->driver);
  SetText(device, device.card, capability->card);
  SetText(device, device.bus(), capability->bus_info);
  capability->version = 6U << 16 | 1U << 8;
  capability->device_caps = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING | V4L2_CAP_EXT_PIX_FORMAT;
  if (device.kind == Device::Kind::kOutput) {
    capability->device_caps = V4L2_CAP_VIDEO_OUTPUT | V4L2_CAP_STREAMING | V4L2_CAP_EXT_PIX_FORMAT;
  } else if (device.kind == Device::Kind::kMetadata) {
    capability->device_caps = V4L2_CAP_META_CAPTURE | V4L2_CAP_STREAMING | V4L2_CAP_EXT_PIX_FORMAT;
  }
  // Of the whole device: a camera's node for metadata has that of images here, too.
  capability->capabilities = capability->device_caps | V4L2_CAP_DEVICE_CAPS;
  if (device.kind == Device::Kind::kMetadata) capability->capabilities |= V4L2_CAP_VIDEO_CAPTURE;
  return 0;
}

int EmulatedFile::FormatIoctl(const Device& device, unsigned long request, void* argument) {
  switch (request) {
    case VIDIOC_ENUM_FMT:
      return EnumerateFormats(device, static_cast<v4l2_fmtdesc*>(argument));
    case VIDIOC_ENUM_FRAMESIZES:
      return EnumerateSizes(device, static_cast<v4l2_frmsizeenum*>(argument));
    case VIDIOC_ENUM_FRAMEINTERVALS:
      return EnumerateIntervals(device, static_cast<v4l2_frmivalenum*>(argument));
    case VIDIOC_G_FMT:
      return GetFormat(LoadState(root_, device), device, static_cast<v4l2_format*>(argument));
    case VIDIOC_TRY_FMT:
      return TryFormat(device, static_cast<v4l2_format*>(argument));
    case VIDIOC_S_FMT:
      return SetFormat(device, static_cast<v4l2_format*>(argument));
    case VIDIOC_G_PARM:
      return Parameters(device, false, static_cast<v4l2_streamparm*>(argument));
    case VIDIOC_S_PARM:
      return Parameters(device, true, static_cast<v4l2_streamparm*>(argument));
    case VIDIOC_ENUMINPUT:
      return EnumerateInput(device, static_cast<v4l2_input*>(argument));
    case VIDIOC_G_INPUT:
      *static_cast<int*>(argument) = 0;
      return 0;
    case VIDIOC_S_INPUT:
      return *static_cast<int*>(argument) == 0 ? 0 : EINVAL;
    default:
      return ENOTTY;
  }
}

int EmulatedFile::SetFormat(const Device& device, v4l2_format* format) {
  if (!IsFree() || !queue_.buffers().empty()) return EBUSY;
  DeviceState state = LoadState(root_, device);
  const int error = ChooseFormat(device, format, &state);
  if (error == 0) SaveState(root_, device, state);
  return error;
}

int EmulatedFile::TryFormat(const Device& device, v4l2_format* format) const {
  DeviceState state = LoadState(root_, device);
  return ChooseFormat(device, format, &state);
}

int EmulatedFile::Parameters(const Device& device, bool set, v4l2_streamparm* parameters) {
  if (!IsCapture(parameters->type)) return EINVAL;
  DeviceState state = LoadState(root_, device);
  if (set) {
    if (!IsFree() || queue_.streaming()) return EBUSY;
    const v4l2_fract interval = parameters->parm.capture.timeperframe;
    state.rate = NearestRate(device, state, {interval.denominator, interval.numerator});
    SaveState(root_, device, state);
  }
  parameters->parm.capture = v4l2_captureparm{};
  parameters->parm.capture.capability = V4L2_CAP_TIMEPERFRAME;
  parameters->parm.capture.timeperframe = {
      device.Answer("interval_numerator", state.rate.denominator),
      device.Answer("interval_denominator", state.rate.numerator)};
  return 0;
}

int EmulatedFile::BufferIoctl(const Device& device, unsigned long request, void* argument) {
  switch (request) {
    case VIDIOC_REQBUFS:
      return RequestBuffers(device, static_cast<v4l2_requestbuffers*>(argument));
    case VIDIOC_QUERYBUF:
      return QueryBuffer(device, static_cast<v4l2_buffer*>(argument));
    case VIDIOC_QBUF:
      return QueueBuffer(device, static_cast<v4l2_buffer*>(argument));
    case VIDIOC_DQBUF:
      return DequeueBuffer(device, static_cast<v4l2_buffer*>(argument));
    case VIDIOC_STREAMON:
      return StartStreaming(device, *static_cast<int*>(argument));
    case VIDIOC_STREAMOFF:
      return StopStreaming(*static_cast<int*>(argument));
    default:
      return ENOTTY;
  }
}

int EmulatedFile::RequestBuffers(const Device& device, v4l2_requestbuffers* request) {
  if (!IsCapture(request->type)) return EINVAL;
  request->capabilities = V4L2_BUF_CAP_SUPPORTS_MMAP | V4L2_BUF_CAP_SUPPORTS_ORPHANED_BUFS;
  if (request->memory != V4L2_MEMORY_MMAP) return EINVAL;
  request->flags = 0;
  if (!TakeOwnership() || queue_.streaming()) return EBUSY;
  uint32_t count = request->count;
  if (count > 0) count = device.Answer("buffer_count", std::min(std::max(count, 2U), kMostBuffers));
  request->count = count;
  const DeviceState state = LoadState(root_, device);
  queue_.Allocate(std::min(count, kMostBuffers),
                  SizeImage(device, state.fourcc, state.width, state.height));
  if (count == 0) GiveUpOwnership();
  return 0;
}

void EmulatedFile::Describe(const Device& device, uint32_t index, v4l2_buffer* buffer) {
  using Owner = CaptureQueue::Buffer::Owner;
  const CaptureQueue::Buffer& from = queue_.buffers()[index];
  const uint32_t type = buffer->type;
  *buffer = v4l2_buffer{};
  buffer->index = index;
  buffer->type = type;
  buffer->memory = V4L2_MEMORY_MMAP;
  buffer->length = device.Answer("buffer_length", from.length);
  buffer->m.offset = static_cast<uint32_t>(index * InPages(from.length));
  buffer->flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  if (from.mapped) buffer->flags |= V4L2_BUF_FLAG_MAPPED;
  if (from.owner == Owner::kDevice) buffer->flags |= V4L2_BUF_FLAG_QUEUED;
  if (from.owner == Owner::kDone) buffer->flags |= V4L2_BUF_FLAG_DONE;
}

int EmulatedFile::QueryBuffer(const Device& device, v4l2_buffer* buffer) {
  if (!IsCapture(buffer->type) || buffer->index >= queue_.buffers().size()) return EINVAL;
  Describe(device, buffer->index, buffer);
  return 0;
}

int EmulatedFile::QueueBuffer(const Device& device, v4l2_buffer* buffer) {
  if (!IsCapture(buffer->type)) return EINVAL;
  if (!IsFree()) return EBUSY;
  if (buffer->index >= queue_.buffers().size() || buffer->memory != V4L2_MEMORY_MMAP ||
      queue_.buffers()[buffer->index].owner != CaptureQueue::Buffer::Owner::kClient) {
    return EINVAL;
  }
  queue_.Queue(buffer->index);
  Describe(device, buffer->index, buffer);
  return 0;
}

int EmulatedFile::DequeueBuffer(const Device& device, v4l2_buffer* buffer) {
  if (!IsCapture(buffer->type)) return EINVAL;
  if (!IsFree()) return EBUSY;
  if (!queue_.streaming() || buffer->memory != V4L2_MEMORY_MMAP) return EINVAL;
  const std::optional<uint32_t> index = queue_.Dequeue();
  if (!index) return EAGAIN;
  Describe(device, *index, buffer);
  const CaptureQueue::Buffer& from = queue_.buffers()[*index];
  buffer->bytesused = from.bytes_used;
  buffer->sequence = from.sequence;
  buffer->field = V4L2_FIELD_NONE;
  buffer->timestamp.tv_sec = from.stamp_us / 1'000'000;
  buffer->timestamp.tv_usec = from.stamp_us % 1'000'000;
  if (from.error) buffer->flags |= V4L2_BUF_FLAG_ERROR;
  return 0;
}

int EmulatedFile::StartStreaming(const Device& device, int type) {
  if (!IsCapture(static_cast<uint32_t>(type))) return EINVAL;
  if (!IsFree()) return EBUSY;
  if (queue_.buffers().empty()) return EINVAL;
  if (queue_.streaming()) return 0;
  const DeviceState state = LoadState(root_, device);
  const double rate = device.speed * state.rate.numerator / std::max(state.rate.denominator, 1U);
  const int64_t period =
      rate > 0.0 ? std::llround(static_cast<double>(kSecond) / rate) : 100 * kSecond;
  queue_.Start(DrawFrames(device, state.fourcc, state.width, state.height),
               std::max<int64_t>(period, 1),
               NowNs());
  return 0;
}

int EmulatedFile::StopStreaming(int type) {
  if (!IsCapture(static_cast<uint32_t>(type))) return EINVAL;
  if (!IsFree()) return EBUSY;
  queue_.Stop();
  return 0;
}

int EmulatedFile::BufferFile(size_t length, int64_t offset, int* error) {
  *error = EINVAL;
  for (size_t i = 0; i < queue_.buffers().size(); ++i) {
    CaptureQueue::Buffer& buffer = queue_.buffers()[i];
    const int64_t size = InPages(buffer.length);
    if (offset != static_cast<int64_t>(i) * size) continue;
    if (static_cast<int64_t>(length) > size) return -1;
    buffer.mapped = true;
    return buffer.memory_file;
  }
  return -1;
}

short EmulatedFile::PollEvents(const Device& device) {
  queue_.Advance(device, NowNs());
  if (!queue_.streaming()) return POLLERR;
  if (device.Fault("poll_hangup", queue_.next_frame()) != nullptr) return POLLERR | POLLHUP;
  if (device.Fault("poll_error", queue_.next_frame()) != nullptr) return POLLERR;
  return queue_.has_done() ? POLLIN | POLLRDNORM : 0;
}

void EmulatedFile::Arm(int fd) const {
  itimerspec time{};
  if (queue_.has_done()) {
    time.it_value.tv_nsec = 1;  // Long ago: readable at once.
  } else if (queue_.streaming()) {
    time.it_value.tv_sec = queue_.next_ns() / kSecond;
    time.it_value.tv_nsec = queue_.next_ns() % kSecond;
  }
  timerfd_settime(fd, TFD_TIMER_ABSTIME, &time, nullptr);
}

}  // namespace vantage::v4l2_shim
