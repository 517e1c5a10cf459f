#include "bus/receive_buffer.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

namespace vantage {
namespace {

std::vector<int> OpenFiles() {
  std::vector<int> files;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd", error)) {
    const std::string name = entry.path().filename().string();
    int file = -1;
    std::from_chars(name.data(), name.data() + name.size(), file);
    if (file >= 0) files.push_back(file);
  }
  return files;
}

bool IsUdpSocketOn(int file, uint16_t port) {
  int type = 0;
  socklen_t size = sizeof type;
  if (getsockopt(file, SOL_SOCKET, SO_TYPE, &type, &size) != 0 || type != SOCK_DGRAM) return false;
  sockaddr_in address{};
  size = sizeof address;
  return getsockname(file, reinterpret_cast<sockaddr*>(&address), &size) == 0 &&
         address.sin_family == AF_INET && ntohs(address.sin_port) == port;
}

int GrantedBytes(int file) {
  int granted = 0;
  socklen_t size = sizeof granted;
  if (getsockopt(file, SOL_SOCKET, SO_RCVBUF, &granted, &size) != 0) return 0;
  return granted / 2;
}

}  // namespace

int GrowReceiveBuffers(uint16_t port, int requested) {
  int smallest = -1;
  for (const int file : OpenFiles()) {
    if (!IsUdpSocketOn(file, port)) continue;
    for (const int option : {SO_RCVBUF, SO_RCVBUFFORCE}) {
      // Refused without CAP_NET_ADMIN; what was granted is read back in any case.
      if (GrantedBytes(file) < requested) {
        setsockopt(file, SOL_SOCKET, option, &requested, sizeof requested);
      }
    }
    const int granted = GrantedBytes(file);
    smallest = smallest < 0 ? granted : std::min(smallest, granted);
  }
  return smallest;
}

}  // namespace vantage
