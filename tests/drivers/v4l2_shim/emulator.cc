#include "tests/drivers/v4l2_shim/emulator.h"

#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <sys/file.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "tests/drivers/v4l2_shim/device_tree.h"

namespace vantage::v4l2_shim {
namespace {

namespace fs = std::filesystem;

thread_local bool in_session = false;
std::atomic<size_t> num_files = 0;

// Neither is ever destroyed: calls come until the process ends.
std::mutex& Mutex() {
  static auto* mutex = [] {
    pthread_atfork([] { Mutex().lock(); }, [] { Mutex().unlock(); }, [] { Mutex().unlock(); });
    return new std::mutex;
  }();
  return *mutex;
}

Emulator& TheEmulator() {
  static auto* emulator = new Emulator;
  return *emulator;
}

// Empty: none that is emulated.
std::string CallName(unsigned long request) {
  static const std::map<unsigned long, std::string> kNames = {
      {VIDIOC_QUERYCAP, "QUERYCAP"},
      {VIDIOC_ENUM_FMT, "ENUM_FMT"},
      {VIDIOC_ENUM_FRAMESIZES, "ENUM_FRAMESIZES"},
      {VIDIOC_ENUM_FRAMEINTERVALS, "ENUM_FRAMEINTERVALS"},
      {VIDIOC_G_FMT, "G_FMT"},
      {VIDIOC_S_FMT, "S_FMT"},
      {VIDIOC_TRY_FMT, "TRY_FMT"},
      {VIDIOC_G_PARM, "G_PARM"},
      {VIDIOC_S_PARM, "S_PARM"},
      {VIDIOC_REQBUFS, "REQBUFS"},
      {VIDIOC_QUERYBUF, "QUERYBUF"},
      {VIDIOC_QBUF, "QBUF"},
      {VIDIOC_DQBUF, "DQBUF"},
      {VIDIOC_STREAMON, "STREAMON"},
      {VIDIOC_STREAMOFF, "STREAMOFF"},
      {VIDIOC_QUERYCTRL, "QUERYCTRL"},
      {VIDIOC_QUERY_EXT_CTRL, "QUERY_EXT_CTRL"},
      {VIDIOC_QUERYMENU, "QUERYMENU"},
      {VIDIOC_G_CTRL, "G_CTRL"},
      {VIDIOC_S_CTRL, "S_CTRL"},
      {VIDIOC_G_EXT_CTRLS, "G_EXT_CTRLS"},
      {VIDIOC_S_EXT_CTRLS, "S_EXT_CTRLS"},
      {VIDIOC_TRY_EXT_CTRLS, "TRY_EXT_CTRLS"},
      {VIDIOC_ENUMINPUT, "ENUMINPUT"},
      {VIDIOC_G_INPUT, "G_INPUT"},
      {VIDIOC_S_INPUT, "S_INPUT"}};
  const auto found = kNames.find(request);
  return found == kNames.end() ? "" : found->second;
}

bool IsSame(const struct stat& a, const struct stat& b) {
  return a.st_ino == b.st_ino && a.st_size == b.st_size && a.st_mtim.tv_sec == b.st_mtim.tv_sec &&
         a.st_mtim.tv_nsec == b.st_mtim.tv_nsec && a.st_ctim.tv_nsec == b.st_ctim.tv_nsec;
}

}  // namespace

void Emulator::Refresh(const std::string& description_file) {
  struct stat now {};
  if (stat(description_file.c_str(), &now) != 0) {
    throw std::runtime_error(description_file + " is not there");
  }
  if (description_file == description_file_ && IsSame(now, seen_)) return;
  root_ = fs::absolute(description_file).lexically_normal().string() + ".root";
  fs::create_directories(root_);
  root_ = fs::canonical(root_);
  // Other processes do the same; who reads last has the last word.
  const int lock = open((root_ / "lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  flock(lock, LOCK_EX);
  stat(description_file.c_str(), &now);
  std::ifstream stream(description_file);
  devices_ = ParseDescription({std::istreambuf_iterator<char>(stream), {}});
  UpdateTree(root_, devices_);
  close(lock);
  description_file_ = description_file;
  seen_ = now;
  std::erase_if(failures_, [this](const auto& failure) {
    return std::ranges::none_of(devices_, [&failure](const Device& device) {
      return std::ranges::any_of(device.fails, [&](const CallFault& fault) {
        return failure.first == std::to_string(device.number) + fault.line;
      });
    });
  });
}

std::string Emulator::Public(const std::string& path) const {
  const std::string root = root_.string() + "/";
  return path.starts_with(root) ? path.substr(root.size() - 1) : path;
}

std::optional<std::string> Emulator::Redirect(int dirfd, const std::string& path, bool as_folder) {
  std::string full = path;
  if (!path.starts_with('/') && dirfd != AT_FDCWD) {
    std::error_code error;
    full = fs::read_symlink("/proc/self/fd/" + std::to_string(dirfd), error) / path;
  }
  full = Public(full);
  const bool is_dev = as_folder && (full == "/dev" || full == "/dev/");
  if (!is_dev && !IsEmulatedPath(full)) return std::nullopt;
  return root_.string() + full;
}

const Device* Emulator::NodeAt(const std::string& redirected) {
  std::error_code error;
  const std::optional<int> number = NodeNumber(Public(fs::canonical(redirected, error)));
  return number ? Numbered(*number) : nullptr;
}

const Device* Emulator::Numbered(int number) const {
  const auto found = std::ranges::find(devices_, number, &Device::number);
  return found == devices_.end() ? nullptr : &*found;
}

const Device* Emulator::DeviceOf(const EmulatedFile& file) const {
  const Device* device = Numbered(file.number());
  return device != nullptr && device->serial == file.serial() ? device : nullptr;
}

int Emulator::Failure(const Device& device, const std::string& call) {
  for (const CallFault& fault : device.fails) {
    if (fault.call != call) continue;
    int& failures = failures_[std::to_string(device.number) + fault.line];
    if (fault.times > 0 && failures >= fault.times) continue;
    ++failures;
    return fault.error;
  }
  return 0;
}

int Emulator::OpenError(const Device& device) { return Failure(device, "OPEN"); }

int Emulator::Open(const Device& device, int flags) {
  errno = OpenError(device);
  if (errno != 0) return -1;
  const int fd = timerfd_create(CLOCK_MONOTONIC,
                                ((flags & O_CLOEXEC) != 0 ? TFD_CLOEXEC : 0) |
                                    ((flags & O_NONBLOCK) != 0 ? TFD_NONBLOCK : 0));
  if (fd >= 0) files_[fd] = std::make_unique<EmulatedFile>(root_, device);
  num_files = files_.size();
  return fd;
}

bool Emulator::HasFiles() { return num_files > 0; }

void Emulator::Close(int fd) {
  files_.erase(fd);
  num_files = files_.size();
}

EmulatedFile* Emulator::File(int fd) {
  const auto found = files_.find(fd);
  return found == files_.end() ? nullptr : found->second.get();
}

int Emulator::Ioctl(EmulatedFile* file, int fd, unsigned long request, void* argument) {
  const Device* device = DeviceOf(*file);
  if (device == nullptr) return ENODEV;
  if (device->kind == Device::Kind::kNull) return ENOTTY;
  request &= UINT32_MAX;
  const std::string name = CallName(request);
  if (name.empty()) return ENOTTY;
  if (argument == nullptr) return EFAULT;
  if (const int error = Failure(*device, name); error != 0) return error;
  return file->Ioctl(*device, fd, request, argument);
}

int Emulator::BufferFile(EmulatedFile* file, size_t length, int64_t offset) {
  const Device* device = DeviceOf(*file);
  int error = device == nullptr ? ENODEV : Failure(*device, "MMAP");
  if (error == 0) {
    const int memory = file->BufferFile(length, offset, &error);
    if (memory >= 0) return memory;
  }
  errno = error;
  return -1;
}

short Emulator::PollEvents(EmulatedFile* file) {
  const Device* device = DeviceOf(*file);
  return device == nullptr ? POLLERR | POLLHUP : file->PollEvents(*device);
}

Session::Session() {
  if (in_session) return;
  const char* file = std::getenv("VANTAGE_V4L2_SHIM");
  if (file == nullptr || *file == '\0') return;
  lock_ = std::unique_lock(Mutex());
  in_session = true;
  const int error = errno;
  try {
    TheEmulator().Refresh(file);
  } catch (const std::exception& refusal) {
    std::fprintf(stderr, "v4l2_shim: %s: %s\n", file, refusal.what());
    std::abort();
  }
  errno = error;
}

Session::~Session() {
  if (lock_.owns_lock()) in_session = false;
}

Emulator* Session::operator->() const { return &TheEmulator(); }

}  // namespace vantage::v4l2_shim
