#include "bus/log_window.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace vantage {
namespace {

constexpr int64_t kBlockBytes = 512 << 10;

}  // namespace

LogWindow::LogWindow(int descriptor, int64_t size) : descriptor_(descriptor), size_(size) {
  // A hint: what it answers makes no difference.
  static_cast<void>(posix_fadvise(descriptor_, 0, 0, POSIX_FADV_SEQUENTIAL));
}

LogWindow::~LogWindow() { close(descriptor_); }

std::span<const std::byte> LogWindow::At(int64_t offset, int64_t count) {
  count = std::min(count, size_ - offset);
  if (count <= 0) return {};
  if (offset < begin_ || offset + count > end_) {
    const bool overlaps = offset >= begin_ && offset < end_;
    const int64_t kept = overlaps ? end_ - offset : 0;
    const int64_t wanted = std::min(std::max(count, kBlockBytes), size_ - offset);
    const std::byte* from = buffer_.get() + (offset - begin_);
    if (wanted > capacity_) {
      auto larger = std::make_unique_for_overwrite<std::byte[]>(static_cast<size_t>(wanted));
      if (kept > 0) std::memcpy(larger.get(), from, static_cast<size_t>(kept));
      buffer_ = std::move(larger);
      capacity_ = wanted;
    } else if (kept > 0) {
      std::memmove(buffer_.get(), from, static_cast<size_t>(kept));
    }
    begin_ = offset;
    end_ = offset + kept;
    const std::span<std::byte> rest(buffer_.get() + kept, static_cast<size_t>(wanted - kept));
    if (!Read(end_, rest)) return {};
    end_ = offset + wanted;
  }
  return {buffer_.get() + (offset - begin_), static_cast<size_t>(count)};
}

bool LogWindow::Peek(int64_t offset, std::span<std::byte> bytes) {
  const auto count = static_cast<int64_t>(bytes.size());
  if (offset < 0 || offset > size_ - count) return false;
  if (offset < begin_ || offset + count > end_) return Read(offset, bytes);
  std::memcpy(bytes.data(), buffer_.get() + (offset - begin_), bytes.size());
  return true;
}

bool LogWindow::Read(int64_t offset, std::span<std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t count = pread(descriptor_, bytes.data(), bytes.size(), offset);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) {
      error_ = count < 0 ? std::strerror(errno) : "the file became shorter";
      return false;
    }
    bytes = bytes.subspan(static_cast<size_t>(count));
    offset += count;
  }
  return true;
}

}  // namespace vantage
