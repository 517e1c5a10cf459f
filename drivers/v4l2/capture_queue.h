#pragma once

#include <linux/videodev2.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/result.h"

namespace vantage {

/// A filled buffer of a device: nothing about it can be trusted.
struct CapturedBuffer {
  std::span<const std::byte> data;
  int64_t index = 0;  ///< as the driver counts images
  int64_t time_us =
      0;              ///< us of CLOCK_MONOTONIC: the driver's stamp; of its arrival if it has none
  std::string fault;  ///< why it can't be used; empty: it can
};

/// The buffers of an open device, mapped into this process, on their way between driver and
/// program.
class CaptureQueue {
 public:
  enum class Outcome {
    kFilled,
    kTimeout,
    kError,  ///< the driver failed, perhaps for once
    kGone,   ///< unplugged
  };

  /// Buffers for images of at least `image_bytes`. `fd` outlives the queue.
  /// Errors: another program streams; fewer than 2 buffers; buffers that are too small or absurd.
  static Result<std::unique_ptr<CaptureQueue>> Create(int fd,
                                                      uint32_t buffer_type,
                                                      int64_t image_bytes,
                                                      const std::string& path);
  ~CaptureQueue();
  CaptureQueue(const CaptureQueue&) = delete;
  CaptureQueue& operator=(const CaptureQueue&) = delete;

  /// Whether the driver stamps images with CLOCK_MONOTONIC.
  [[nodiscard]] bool has_stamps() const { return has_stamps_; }

  /// Gives all buffers to the driver and starts it.
  Result<void> Start();
  /// Waits for an image. It is valid until the next call, which gives its buffer back.
  Outcome Dequeue(std::chrono::milliseconds timeout, CapturedBuffer* captured);

 private:
  CaptureQueue(int fd, uint32_t buffer_type, const std::string& path)
      : fd_(fd), buffer_type_(buffer_type), path_(path) {}

  Result<void> Map(uint32_t index, int64_t image_bytes);
  int Give(uint32_t index);
  Outcome Take(CapturedBuffer* captured);

  int fd_;
  uint32_t buffer_type_;
  std::string path_;
  std::vector<std::span<std::byte>> memory_;
  bool has_stamps_ = false;
  int64_t taken_ = -1;  // Index of the buffer that the program has; -1: none.
};

}  // namespace vantage
