#include "drivers/v4l2/v4l2_ioctl.h"

#include <fcntl.h>
#include <grp.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <system_error>
#include <utility>

#include "common/format.h"

namespace vantage {
namespace {

constexpr unsigned int kVideoMajor = 81;  // of the kernel's devices.txt

std::string GroupName(gid_t gid) {
  std::array<char, 4096> buffer{};
  group entry{};
  group* found = nullptr;
  if (getgrgid_r(gid, &entry, buffer.data(), buffer.size(), &found) != 0 || found == nullptr) {
    return Format("%u", gid);
  }
  return found->gr_name;
}

Error NoPermission(const std::string& path) {
  std::string message = Format("device %s can't be opened: permission denied", path.c_str());
  struct stat node {};
  if (stat(path.c_str(), &node) == 0) {
    const std::string group_name = GroupName(node.st_gid);
    message += Format(
        "; it belongs to the group %s: `sudo usermod -aG %s $USER` and a new login let you in",
        group_name.c_str(),
        group_name.c_str());
  }
  return {ErrorCode::kUnavailable, message};
}

}  // namespace

FileDescriptor::FileDescriptor(FileDescriptor&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)) {}

FileDescriptor& FileDescriptor::operator=(FileDescriptor&& other) noexcept {
  std::swap(fd_, other.fd_);
  return *this;
}

FileDescriptor::~FileDescriptor() {
  if (fd_ >= 0) close(fd_);
}

int Ioctl(int fd, unsigned long request, void* argument) {
  while (ioctl(fd, request, argument) != 0) {
    if (errno != EINTR) return errno;
  }
  return 0;
}

Error SystemError(const std::string& path, const std::string& what, int error) {
  const char* mend = "";
  if (error == EBUSY) {
    mend = "; another program streams from it: `fuser -v /dev/video*` tells which";
  } else if (error == ENODEV) {
    mend = "; it was unplugged";
  } else if (error == ENOSPC) {
    mend =
        "; its USB bus has no bandwidth left: fewer cameras on it, or a smaller or packed format";
  }
  return {ErrorCode::kUnavailable,
          Format("device %s %s: %s%s",
                 path.c_str(),
                 what.c_str(),
                 std::generic_category().message(error).c_str(),
                 mend)};
}

Result<FileDescriptor> OpenVideoNode(const std::string& path) {
  struct stat node {};
  // To open whatever has that name could do things: a watchdog begins to count.
  if (stat(path.c_str(), &node) == 0) {
    if (!S_ISCHR(node.st_mode)) {
      return Error{ErrorCode::kInvalidArgument,
                   Format("device %s is no character device, expected one such as /dev/video0",
                          path.c_str())};
    }
    if (major(node.st_rdev) != kVideoMajor) {
      return Error{ErrorCode::kInvalidArgument,
                   Format("device %s has the major number %u, expected %u of a video device such "
                          "as /dev/video0",
                          path.c_str(),
                          major(node.st_rdev),
                          kVideoMajor)};
    }
  }
  int fd = -1;
  do {
    fd = open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  } while (fd < 0 && errno == EINTR);
  if (fd >= 0) return FileDescriptor(fd);
  if (errno == EACCES || errno == EPERM) return NoPermission(path);
  return SystemError(path, "can't be opened", errno);
}

}  // namespace vantage
