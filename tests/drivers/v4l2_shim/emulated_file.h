#pragma once

#include <linux/videodev2.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

#include "tests/drivers/v4l2_shim/capture_queue.h"
#include "tests/drivers/v4l2_shim/description.h"
#include "tests/drivers/v4l2_shim/device_state.h"

namespace vantage::v4l2_shim {

/// One open descriptor of a device: a timer that is readable when a frame is due. Calls give 0 or
/// an errno. `device` is what the description says of it at the time of the call.
class EmulatedFile {
 public:
  EmulatedFile(std::filesystem::path root, const Device& device);
  ~EmulatedFile();
  EmulatedFile(const EmulatedFile&) = delete;
  EmulatedFile& operator=(const EmulatedFile&) = delete;

  [[nodiscard]] int number() const { return number_; }
  [[nodiscard]] const std::string& serial() const { return serial_; }

  /// All requests but the waiting of VIDIOC_DQBUF, which is EAGAIN.
  int Ioctl(const Device& device, int fd, unsigned long request, void* argument);
  /// The descriptor that stands for the buffer; -1 and `error` set: none.
  int BufferFile(size_t length, int64_t offset, int* error);
  /// What poll() says of the descriptor.
  short PollEvents(const Device& device);
  /// Sets the timer to the next frame, or to now when one waits.
  void Arm(int fd) const;

 private:
  int QueryCapability(const Device& device, v4l2_capability* capability) const;
  int TryFormat(const Device& device, v4l2_format* format) const;
  int SetFormat(const Device& device, v4l2_format* format);
  int Parameters(const Device& device, bool set, v4l2_streamparm* parameters);

  int RequestBuffers(const Device& device, v4l2_requestbuffers* request);
  int QueryBuffer(const Device& device, v4l2_buffer* buffer);
  int QueueBuffer(const Device& device, v4l2_buffer* buffer);
  int DequeueBuffer(const Device& device, v4l2_buffer* buffer);
  int StartStreaming(const Device& device, int type);
  int StopStreaming(int type);
  void Describe(const Device& device, uint32_t index, v4l2_buffer* buffer);

  int BufferIoctl(const Device& device, unsigned long request, void* argument);
  int FormatIoctl(const Device& device, unsigned long request, void* argument);

  /// True for who may change formats and buffers: nobody else has buffers.
  [[nodiscard]] bool IsFree() const;
  bool TakeOwnership();
  void GiveUpOwnership();

  std::filesystem::path root_;
  int number_;
  std::string serial_;
  int owner_file_ = -1;  // Locked by who has the device's buffers.
  bool is_owner_ = false;
  CaptureQueue queue_;
};

}  // namespace vantage::v4l2_shim
