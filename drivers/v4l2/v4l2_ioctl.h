#pragma once

#include <string>

#include "common/result.h"

namespace vantage {

/// An open file, closed with this object.
class FileDescriptor {
 public:
  FileDescriptor() = default;
  explicit FileDescriptor(int fd) : fd_(fd) {}
  FileDescriptor(FileDescriptor&& other) noexcept;
  FileDescriptor& operator=(FileDescriptor&& other) noexcept;
  ~FileDescriptor();

  [[nodiscard]] int get() const { return fd_; }
  [[nodiscard]] bool is_open() const { return fd_ >= 0; }

 private:
  int fd_ = -1;
};

/// ioctl(), again for as long as signals interrupt it.
/// @return 0 or an errno.
int Ioctl(int fd, unsigned long request, void* argument);

/// "device /dev/video0 WHAT: REASON", with what mends it where that is known. `what` is a verb with
/// its object, `error` an errno.
Error SystemError(const std::string& path, const std::string& what, int error);

/// Opens a video device's node without waiting.
/// Errors: absent; no character device of video4linux; no permission (names the group that has it).
Result<FileDescriptor> OpenVideoNode(const std::string& path);

}  // namespace vantage
