#include "bus/process_name_lock.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "bus/lcm_url.h"
#include "common/check.h"
#include "common/format.h"

namespace vantage {
namespace {

// The lock is a Unix socket with an abstract name: the kernel keeps such names for each network
// namespace, gives one to one socket only, and takes it back when its process ends.
struct SocketName {
  sockaddr_un address{};
  socklen_t size = 0;
  const sockaddr* Get() const { return reinterpret_cast<const sockaddr*>(&address); }
};

SocketName MakeSocketName(const std::string& name, const std::string& place) {
  const std::string text = "vantage/" + name + "/" + place;
  SocketName made;
  made.address.sun_family = AF_UNIX;
  VANTAGE_CHECK(text.size() < sizeof(made.address.sun_path), text);
  std::ranges::copy(text, made.address.sun_path + 1);  // After a NUL: abstract.
  made.size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + text.size());
  return made;
}

int MakeSocket() { return socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0); }

// The process that listens; 0 when it can't be known, as from inside a container.
pid_t HolderOf(const SocketName& name) {
  const int descriptor = MakeSocket();
  if (descriptor < 0) return 0;
  ucred holder{};
  socklen_t size = sizeof(holder);
  const bool known = connect(descriptor, name.Get(), name.size) == 0 &&
                     getsockopt(descriptor, SOL_SOCKET, SO_PEERCRED, &holder, &size) == 0;
  close(descriptor);
  return known ? holder.pid : 0;
}

bool IsName(const std::string& name) {
  return !name.empty() && name.size() <= 64 && std::ranges::all_of(name, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-' || c == '.';
  });
}

Error IsHeld(const std::string& name, const std::string& place, pid_t holder) {
  const std::string pid = holder > 0 ? Format(" (pid %d)", holder) : "";
  const std::string kill = holder > 0 ? Format("end it with: kill %d, or ", holder) : "";
  return {ErrorCode::kUnavailable,
          Format("a process named '%s' is on %s already%s, expected one of each name; %sstart this "
                 "one with --name OTHER",
                 name.c_str(),
                 place.c_str(),
                 pid.c_str(),
                 kill.c_str())};
}

}  // namespace

Result<std::unique_ptr<ProcessNameLock>> ProcessNameLock::Acquire(const std::string& name,
                                                                  const std::string& url) {
  if (!IsName(name)) {
    return Error{
        ErrorCode::kInvalidArgument,
        Format("process name is '%.80s', expected 1 to 64 letters, digits, '_', '-' or '.'",
               name.c_str())};
  }
  const Result<LcmUrl> parsed = LcmUrl::ParseOrDefault(url);
  if (!parsed) return parsed.error();
  const std::string place = parsed->Place();
  const SocketName socket_name = MakeSocketName(name, place);
  const int descriptor = MakeSocket();
  if (descriptor >= 0 && bind(descriptor, socket_name.Get(), socket_name.size) == 0 &&
      listen(descriptor, SOMAXCONN) == 0) {
    return std::unique_ptr<ProcessNameLock>(new ProcessNameLock(descriptor));
  }
  const int reason = errno;
  if (descriptor >= 0) close(descriptor);
  if (reason == EADDRINUSE) return IsHeld(name, place, HolderOf(socket_name));
  return Error{
      ErrorCode::kIo,
      Format("the name '%s' can't be kept from others: %s", name.c_str(), std::strerror(reason))};
}

ProcessNameLock::~ProcessNameLock() { close(descriptor_); }

}  // namespace vantage
