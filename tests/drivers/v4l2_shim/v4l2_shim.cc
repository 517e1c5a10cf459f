// A library that puts emulated V4L2 devices in the place of the system's: for the program that is
// linked to it, or for any program by
//
//   LD_PRELOAD=.../libv4l2_shim.so VANTAGE_V4L2_SHIM=/tmp/x/devices v4l2-ctl --list-devices
//
// It does nothing unless VANTAGE_V4L2_SHIM names a file, which describes the devices
// (description.cc tells how) and may be changed at any time. Programs then see /dev/video*,
// /dev/v4l and /sys/class/video4linux as they are with just these devices plugged in. Beside the
// file lies <file>.root: what stands for /dev and /sys, and state/videoN.txt with what was set.
// Several processes share the devices as they share real ones: a second one gets EBUSY.
//
// Frames come at their rate, stamped with the time when they were due. Those of a period are drawn
// at STREAMON, or read from a file ("frames FILE"); the thread that dequeues copies them into the
// buffer. That is all that it costs a process: with 640 x 480 px of 16 bits at 30 Hz v4l2-ctl uses
// 0.5 % of a core, its own work included.
#include <dirent.h>
#include <dlfcn.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/inotify.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tests/drivers/v4l2_shim/emulator.h"

namespace vantage::v4l2_shim {
namespace {

constexpr unsigned int kVideoMajor = 81;
constexpr unsigned int kMemoryMajor = 1;  // of /dev/null
constexpr gid_t kVideoGroup = 44;         // Debian's

/// The function of that name in the libraries after this one.
template <class Function>
Function* Next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

/// The emulator where it has a part in a path at all; `redirected` gets where that really is.
bool RedirectInto(std::string* redirected, int dirfd, const char* path, bool as_folder = false) {
  Session session;
  if (!session) return false;
  const std::optional<std::string> real = session->Redirect(dirfd, path, as_folder);
  if (real) *redirected = *real;
  return real.has_value();
}

/// What stat() would say of the device's node.
template <class Stat>
void BecomeNode(const Device& device, Stat* status) {
  if (device.kind == Device::Kind::kFile) return;
  const bool is_video = device.kind != Device::Kind::kNull;
  status->st_mode = S_IFCHR | 0660;
  status->st_uid = 0;
  status->st_gid = kVideoGroup;
  status->st_size = 0;
  status->st_rdev =
      makedev(is_video ? kVideoMajor : kMemoryMajor, static_cast<unsigned int>(device.number));
}

template <class Stat>
int StatRedirected(const std::string& path, int flags, Stat* status) {
  Session session;
  int result = 0;
  if constexpr (std::is_same_v<Stat, struct stat64>) {
    result = fstatat64(AT_FDCWD, path.c_str(), status, flags);
  } else {
    result = fstatat(AT_FDCWD, path.c_str(), status, flags);
  }
  if (result != 0 || S_ISLNK(status->st_mode) || S_ISDIR(status->st_mode)) return result;
  if (const Device* device = session->NodeAt(path)) BecomeNode(*device, status);
  return result;
}

template <class Stat>
bool StatFile(int fd, Stat* status) {
  Session session;
  const EmulatedFile* file = session ? session->File(fd) : nullptr;
  if (file == nullptr) return false;
  *status = Stat{};
  Device device;
  device.number = file->number();
  BecomeNode(device, status);
  return true;
}

int OpenRedirected(const std::string& path, int flags, mode_t mode) {
  Session session;
  const Device* device = session->NodeAt(path);
  if (device == nullptr || device->kind == Device::Kind::kFile) {
    return open(path.c_str(), flags, mode);
  }
  return session->Open(*device, flags);
}

int IoctlFile(int fd, unsigned long request, void* argument) {
  const auto attempt = [&] {
    Session session;
    EmulatedFile* file = session->File(fd);
    return file == nullptr ? EBADF : session->Ioctl(file, fd, request, argument);
  };
  int error = attempt();
  const bool waits = request == VIDIOC_DQBUF && (fcntl(fd, F_GETFL) & O_NONBLOCK) == 0;
  while (waits && error == EAGAIN) {
    pollfd one{fd, POLLIN, 0};
    poll(&one, 1, 1000);
    error = attempt();
  }
  if (error == 0) return 0;
  errno = error;
  return -1;
}

bool IsEmulated(int fd) {
  if (!Emulator::HasFiles()) return false;
  Session session;
  return session && session->File(fd) != nullptr;
}

/// Sets `revents` of emulated devices. @return true: some have news.
bool AskDevices(std::span<pollfd> files) {
  Session session;
  bool news = false;
  for (pollfd& each : files) {
    EmulatedFile* file = session->File(each.fd);
    if (file == nullptr) continue;
    const short events = session->PollEvents(file);
    each.revents = static_cast<short>(events & (each.events | POLLERR | POLLHUP));
    file->Arm(each.fd);
    news = news || each.revents != 0;
  }
  return news;
}

/// poll() in short turns, after each of which the devices are asked.
int PollDevices(std::span<pollfd> files, int timeout_ms) {
  using std::chrono::milliseconds;
  using std::chrono::steady_clock;
  static const auto next = Next<decltype(poll)>("poll");
  constexpr milliseconds kTurn{50};
  const auto start = steady_clock::now();
  while (true) {
    milliseconds turn = kTurn;
    if (timeout_ms >= 0) {
      const auto left =
          milliseconds(timeout_ms) - std::chrono::floor<milliseconds>(steady_clock::now() - start);
      turn = std::clamp(left, milliseconds(0), kTurn);
    }
    if (AskDevices(files)) turn = milliseconds(0);
    const int ready = next(files.data(), files.size(), static_cast<int>(turn.count()));
    if (ready < 0) return ready;
    AskDevices(files);
    const auto count =
        std::ranges::count_if(files, [](const pollfd& one) { return one.revents != 0; });
    if (count > 0) return static_cast<int>(count);
    if (timeout_ms >= 0 && steady_clock::now() - start >= milliseconds(timeout_ms)) return 0;
  }
}

void* MapBuffer(void* address, size_t length, int protection, int flags, int fd, off_t offset) {
  Session session;
  const int memory = session->BufferFile(session->File(fd), length, offset);
  if (memory < 0) return MAP_FAILED;
  return mmap(address, length, protection, flags, memory, 0);
}

int AccessRedirected(const std::string& path, int mode) {
  Session session;
  const Device* device = session->NodeAt(path);
  if (device != nullptr && mode != F_OK) {
    errno = session->OpenError(*device);
    if (errno != 0) return -1;
  }
  return access(path.c_str(), F_OK);
}

mode_t ModeOf(int flags, va_list arguments) {
  return (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(arguments, mode_t) : 0;
}

}  // namespace
}  // namespace vantage::v4l2_shim

using namespace vantage::v4l2_shim;  // NOLINT(google-build-using-namespace): the system's names

#pragma GCC visibility push(default)
extern "C" {

int open(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = ModeOf(flags, arguments);
  va_end(arguments);
  std::string redirected;
  if (RedirectInto(&redirected, AT_FDCWD, path)) return OpenRedirected(redirected, flags, mode);
  static const auto next = Next<decltype(open)>("open");
  return next(path, flags, mode);
}
int open64(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = ModeOf(flags, arguments);
  va_end(arguments);
  return open(path, flags, mode);
}
int openat(int dirfd, const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = ModeOf(flags, arguments);
  va_end(arguments);
  std::string redirected;
  if (RedirectInto(&redirected, dirfd, path)) return OpenRedirected(redirected, flags, mode);
  static const auto next = Next<decltype(openat)>("openat");
  return next(dirfd, path, flags, mode);
}
int openat64(int dirfd, const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = ModeOf(flags, arguments);
  va_end(arguments);
  return openat(dirfd, path, flags, mode);
}
// What _FORTIFY_SOURCE makes of open().
int __open_2(const char* path, int flags);
int __open_2(const char* path, int flags) { return open(path, flags); }
int __open64_2(const char* path, int flags);
int __open64_2(const char* path, int flags) { return open(path, flags); }

int close(int fd) {
  if (Emulator::HasFiles()) {
    Session session;
    if (session) session->Close(fd);
  }
  static const auto next = Next<decltype(close)>("close");
  return next(fd);
}

int ioctl(int fd, unsigned long request, ...) noexcept {
  va_list arguments;
  va_start(arguments, request);
  void* argument = va_arg(arguments, void*);
  va_end(arguments);
  if (IsEmulated(fd)) return IoctlFile(fd, request, argument);
  static const auto next = Next<decltype(ioctl)>("ioctl");
  return next(fd, request, argument);
}

void* mmap(void* address, size_t length, int protection, int flags, int fd, off_t offset) noexcept {
  static const auto next = Next<decltype(mmap)>("mmap");
  if (fd < 0 || !IsEmulated(fd)) return next(address, length, protection, flags, fd, offset);
  return MapBuffer(address, length, protection, flags, fd, offset);
}
void* mmap64(
    void* address, size_t length, int protection, int flags, int fd, off_t offset) noexcept {
  return mmap(address, length, protection, flags, fd, offset);
}

int poll(pollfd* files, nfds_t count, int timeout) {
  const std::span<pollfd> all(files, count);
  if (std::ranges::any_of(all, [](const pollfd& each) { return IsEmulated(each.fd); })) {
    return PollDevices(all, timeout);
  }
  static const auto next = Next<decltype(poll)>("poll");
  return next(files, count, timeout);
}
int __poll_chk(pollfd* files, nfds_t count, int timeout, size_t size);
int __poll_chk(pollfd* files, nfds_t count, int timeout, size_t) {
  return poll(files, count, timeout);
}

ssize_t read(int fd, void* buffer, size_t count) {
  if (IsEmulated(fd)) {
    errno = EINVAL;  // Only streaming.
    return -1;
  }
  static const auto next = Next<decltype(read)>("read");
  return next(fd, buffer, count);
}

int fstatat(int dirfd, const char* path, struct stat* status, int flags) noexcept {
  std::string redirected;
  if (RedirectInto(&redirected, dirfd, path)) return StatRedirected(redirected, flags, status);
  static const auto next = Next<decltype(fstatat)>("fstatat");
  return next(dirfd, path, status, flags);
}
int fstatat64(int dirfd, const char* path, struct stat64* status, int flags) noexcept {
  std::string redirected;
  if (RedirectInto(&redirected, dirfd, path)) return StatRedirected(redirected, flags, status);
  static const auto next = Next<decltype(fstatat64)>("fstatat64");
  return next(dirfd, path, status, flags);
}
int stat(const char* path, struct stat* status) noexcept {
  return fstatat(AT_FDCWD, path, status, 0);
}
int stat64(const char* path, struct stat64* status) noexcept {
  return fstatat64(AT_FDCWD, path, status, 0);
}
int lstat(const char* path, struct stat* status) noexcept {
  return fstatat(AT_FDCWD, path, status, AT_SYMLINK_NOFOLLOW);
}
int lstat64(const char* path, struct stat64* status) noexcept {
  return fstatat64(AT_FDCWD, path, status, AT_SYMLINK_NOFOLLOW);
}
int fstat(int fd, struct stat* status) noexcept {
  if (StatFile(fd, status)) return 0;
  static const auto next = Next<decltype(fstat)>("fstat");
  return next(fd, status);
}
int fstat64(int fd, struct stat64* status) noexcept {
  if (StatFile(fd, status)) return 0;
  static const auto next = Next<decltype(fstat64)>("fstat64");
  return next(fd, status);
}

int statx(int dirfd,
          const char* __restrict path,
          int flags,
          unsigned int mask,
          struct statx* __restrict status) noexcept {
  static const auto next = Next<decltype(statx)>("statx");
  std::string redirected;
  if (!RedirectInto(&redirected, dirfd, path)) return next(dirfd, path, flags, mask, status);
  struct stat node {};
  const int result = next(AT_FDCWD, redirected.c_str(), flags, mask, status);
  if (result != 0 || StatRedirected(redirected, flags & AT_SYMLINK_NOFOLLOW, &node) != 0) {
    return result;
  }
  status->stx_mode = static_cast<uint16_t>(node.st_mode);
  status->stx_gid = node.st_gid;
  status->stx_rdev_major = major(node.st_rdev);
  status->stx_rdev_minor = minor(node.st_rdev);
  return 0;
}

int access(const char* path, int mode) noexcept {
  std::string redirected;
  if (RedirectInto(&redirected, AT_FDCWD, path)) return AccessRedirected(redirected, mode);
  static const auto next = Next<decltype(access)>("access");
  return next(path, mode);
}

FILE* fopen(const char* path, const char* mode) {
  std::string redirected;
  static const auto next = Next<decltype(fopen)>("fopen");
  return next(RedirectInto(&redirected, AT_FDCWD, path) ? redirected.c_str() : path, mode);
}
FILE* fopen64(const char* path, const char* mode) { return fopen(path, mode); }

DIR* opendir(const char* path) {
  std::string redirected;
  static const auto next = Next<decltype(opendir)>("opendir");
  return next(RedirectInto(&redirected, AT_FDCWD, path, true) ? redirected.c_str() : path);
}

ssize_t readlink(const char* path, char* buffer, size_t size) noexcept {
  std::string redirected;
  static const auto next = Next<decltype(readlink)>("readlink");
  return next(RedirectInto(&redirected, AT_FDCWD, path) ? redirected.c_str() : path, buffer, size);
}
ssize_t __readlink_chk(const char* path, char* buffer, size_t size, size_t);
ssize_t __readlink_chk(const char* path, char* buffer, size_t size, size_t) {
  return readlink(path, buffer, size);
}

char* realpath(const char* path, char* resolved) noexcept {
  static const auto next = Next<decltype(realpath)>("realpath");
  std::string redirected;
  if (!RedirectInto(&redirected, AT_FDCWD, path)) return next(path, resolved);
  char* result = next(redirected.c_str(), resolved);
  if (result == nullptr) return nullptr;
  Session session;
  const std::string shown = session->Public(result);
  std::memcpy(result, shown.c_str(), shown.size() + 1);
  return result;
}

int inotify_add_watch(int fd, const char* path, uint32_t mask) noexcept {
  static const auto next = Next<decltype(inotify_add_watch)>("inotify_add_watch");
  std::string redirected;
  return next(
      fd, RedirectInto(&redirected, AT_FDCWD, path, true) ? redirected.c_str() : path, mask);
}

}  // extern "C"
#pragma GCC visibility pop
