#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "tests/drivers/v4l2_shim/description.h"

namespace vantage::v4l2_shim {

/// The buffers of one open device and the frames that come into them.
class CaptureQueue {
 public:
  struct Buffer {
    enum class Owner { kClient, kDevice, kDone };
    int memory_file = -1;  ///< what mmap() maps
    uint8_t* memory = nullptr;
    uint32_t length = 0;  ///< bytes
    bool mapped = false;
    Owner owner = Owner::kClient;
    uint32_t bytes_used = 0;
    uint32_t sequence = 0;
    int64_t stamp_us = 0;  ///< monotonic
    bool error = false;
  };

  CaptureQueue() = default;
  ~CaptureQueue() { Free(); }
  CaptureQueue(const CaptureQueue&) = delete;
  CaptureQueue& operator=(const CaptureQueue&) = delete;

  void Allocate(uint32_t count, uint32_t length);
  void Free();
  /// @param frames shown in turn; where there are none they are empty.
  void Start(std::vector<std::vector<uint8_t>> frames, int64_t period_ns, int64_t now_ns);
  void Stop();
  /// Fills buffers with the frames that have come by now.
  void Advance(const Device& device, int64_t now_ns);
  void Queue(uint32_t index);
  std::optional<uint32_t> Dequeue();

  [[nodiscard]] std::vector<Buffer>& buffers() { return buffers_; }
  [[nodiscard]] bool streaming() const { return streaming_; }
  [[nodiscard]] bool has_done() const { return !done_.empty(); }
  /// The frame that comes next, counted from 0 at Start().
  [[nodiscard]] uint64_t next_frame() const { return next_frame_; }
  /// When, monotonic.
  [[nodiscard]] int64_t next_ns() const {
    return start_ns_ + static_cast<int64_t>(next_frame_ + 1) * period_ns_;
  }

 private:
  void Fill(const Device& device, Buffer* buffer);

  std::vector<Buffer> buffers_;
  std::deque<uint32_t> queued_;
  std::deque<uint32_t> done_;
  std::vector<std::vector<uint8_t>> frames_;
  bool streaming_ = false;
  int64_t start_ns_ = 0;
  int64_t period_ns_ = 1;
  uint64_t next_frame_ = 0;
  uint64_t num_stalled_ = 0;
};

}  // namespace vantage::v4l2_shim
