#include "tests/drivers/v4l2_shim/capture_queue.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace vantage::v4l2_shim {
namespace {

constexpr uint64_t kLongestBacklog = 1000;  // frames; what is older is passed over at once

}  // namespace

void CaptureQueue::Allocate(uint32_t count, uint32_t length) {
  Free();
  for (uint32_t i = 0; i < count; ++i) {
    Buffer buffer;
    buffer.length = length;
    buffer.memory_file = memfd_create("v4l2-buffer", MFD_CLOEXEC);
    if (buffer.memory_file < 0 || ftruncate(buffer.memory_file, length) != 0) {
      throw std::runtime_error("no memory for a buffer");
    }
    if (length > 0) {
      void* memory =
          mmap(nullptr, length, PROT_READ | PROT_WRITE, MAP_SHARED, buffer.memory_file, 0);
      if (memory == MAP_FAILED) throw std::runtime_error("no memory for a buffer");
      buffer.memory = static_cast<uint8_t*>(memory);
    }
    buffers_.push_back(buffer);
  }
}

// What the client has mapped stays in its memory.
void CaptureQueue::Free() {
  Stop();
  for (const Buffer& buffer : buffers_) {
    if (buffer.memory != nullptr) munmap(buffer.memory, buffer.length);
    close(buffer.memory_file);
  }
  buffers_.clear();
}

void CaptureQueue::Start(std::vector<std::vector<uint8_t>> frames,
                         int64_t period_ns,
                         int64_t now_ns) {
  frames_ = std::move(frames);
  period_ns_ = period_ns;
  start_ns_ = now_ns;
  next_frame_ = 0;
  num_stalled_ = 0;
  streaming_ = true;
}

void CaptureQueue::Stop() {
  streaming_ = false;
  queued_.clear();
  done_.clear();
  for (Buffer& buffer : buffers_) buffer.owner = Buffer::Owner::kClient;
}

void CaptureQueue::Advance(const Device& device, int64_t now_ns) {
  if (!streaming_) return;
  const int64_t due = (now_ns - start_ns_) / period_ns_;  // Frames 0..due-1 have come.
  if (due > 0) {
    next_frame_ = std::max(next_frame_,
                           static_cast<uint64_t>(due) -
                               std::min<uint64_t>(static_cast<uint64_t>(due), kLongestBacklog));
  }
  for (; next_ns() <= now_ns; ++next_frame_) {
    if (device.Fault("stall", next_frame_) != nullptr) {
      ++num_stalled_;  // A device that stands still does not count.
      continue;
    }
    if (queued_.empty() || device.Fault("drop", next_frame_) != nullptr) continue;
    const uint32_t index = queued_.front();
    queued_.pop_front();
    Fill(device, &buffers_[index]);
    buffers_[index].owner = Buffer::Owner::kDone;
    done_.push_back(index);
  }
}

void CaptureQueue::Fill(const Device& device, Buffer* buffer) {
  buffer->bytes_used = 0;
  if (!frames_.empty()) {
    const std::vector<uint8_t>& frame = frames_[next_frame_ % frames_.size()];
    buffer->bytes_used = std::min(buffer->length, static_cast<uint32_t>(frame.size()));
    if (buffer->bytes_used > 0) std::memcpy(buffer->memory, frame.data(), buffer->bytes_used);
  }
  buffer->sequence = static_cast<uint32_t>(next_frame_ - num_stalled_);
  buffer->stamp_us = next_ns() / 1000;
  buffer->error = device.Fault("error_flag", next_frame_) != nullptr;
  if (const FrameFault* fault = device.Fault("corrupt", next_frame_)) {
    for (uint32_t i = static_cast<uint32_t>(fault->value); i < buffer->bytes_used; i += 3)
      buffer->memory[i] ^= 0xFF;
  }
  if (const FrameFault* fault = device.Fault("bytesused", next_frame_)) {
    buffer->bytes_used = static_cast<uint32_t>(fault->value);
  }
  if (const FrameFault* fault = device.Fault("sequence", next_frame_)) {
    buffer->sequence += static_cast<uint32_t>(fault->value);
  }
  if (device.Fault("stamp_still", next_frame_) != nullptr) {
    buffer->stamp_us = (start_ns_ + period_ns_) / 1000;
  }
  if (const FrameFault* fault = device.Fault("stamp", next_frame_)) {
    buffer->stamp_us += fault->value;
  }
}

void CaptureQueue::Queue(uint32_t index) {
  buffers_[index].owner = Buffer::Owner::kDevice;
  queued_.push_back(index);
}

std::optional<uint32_t> CaptureQueue::Dequeue() {
  if (done_.empty()) return std::nullopt;
  const uint32_t index = done_.front();
  done_.pop_front();
  buffers_[index].owner = Buffer::Owner::kClient;
  return index;
}

}  // namespace vantage::v4l2_shim
