#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

namespace vantage {

/// A file seen through a buffer that moves along it: read in blocks, as much memory as a block or
/// the longest stretch that was asked for. Closes its descriptor.
class LogWindow {
 public:
  /// @param size bytes of the file that count, however it grows.
  LogWindow(int descriptor, int64_t size);
  ~LogWindow();
  LogWindow(const LogWindow&) = delete;
  LogWindow& operator=(const LogWindow&) = delete;

  /// `count` bytes from `offset` on, fewer where the file ends or can't be read. Valid until the
  /// next call of At().
  std::span<const std::byte> At(int64_t offset, int64_t count);
  /// Reads without moving the buffer. False when the file has fewer bytes or can't be read.
  bool Peek(int64_t offset, std::span<std::byte> bytes);

  [[nodiscard]] int64_t size() const { return size_; }
  /// Why the system refused to read; empty: it did not.
  [[nodiscard]] const std::string& error() const { return error_; }

 private:
  bool Read(int64_t offset, std::span<std::byte> bytes);

  int descriptor_;
  int64_t size_;
  std::unique_ptr<std::byte[]> buffer_;
  int64_t capacity_ = 0;
  int64_t begin_ = 0;  // What the buffer holds of the file.
  int64_t end_ = 0;
  std::string error_;
};

}  // namespace vantage
