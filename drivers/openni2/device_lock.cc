#include "drivers/openni2/device_lock.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <thread>

#include "common/format.h"

namespace vantage {
namespace {

constexpr std::chrono::milliseconds kInterval{5};

// FNV-1a, 64 bits: the name of a lock has less room than a URI.
uint64_t Hash(const std::string& text) {
  uint64_t hash = 0xcbf29ce484222325ULL;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  return hash;
}

// Binds a Unix socket to an abstract name, which the kernel gives to one socket only and takes back
// when its process ends. 0, or errno.
int Bind(int descriptor, const std::string& name) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path + 1, name.data(), name.size());  // After a NUL: abstract.
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
  return bind(descriptor, reinterpret_cast<const sockaddr*>(&address), size) == 0 ? 0 : errno;
}

}  // namespace

Result<std::unique_ptr<DeviceLock>> DeviceLock::Acquire(const std::string& uri,
                                                        std::chrono::milliseconds timeout) {
  const std::string name =
      Format("vantage/openni2/%016llx", static_cast<unsigned long long>(Hash(uri)));
  const int descriptor = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  std::unique_ptr<DeviceLock> lock(new DeviceLock(descriptor));
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  while (descriptor >= 0 && Bind(descriptor, name) == EADDRINUSE) {
    if (std::chrono::steady_clock::now() >= deadline) {
      return Error{ErrorCode::kUnavailable,
                   Format("device %s has been looked at by another program for %.1f s",
                          uri.c_str(),
                          1e-3 * static_cast<double>(timeout.count()))};
    }
    std::this_thread::sleep_for(kInterval);
  }
  return lock;
}

DeviceLock::~DeviceLock() {
  if (descriptor_ >= 0) close(descriptor_);
}

}  // namespace vantage
